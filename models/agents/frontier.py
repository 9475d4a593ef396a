"""``frontier``: explores the nearest unknown, looks at what it passes, opens what is closed. Reads no habits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.agents.base import Controller, ControllerAgent, Info
from models.agents.search import SearchController
from ucon.perception.places import Places, affordance, has_room
from ucon.perception.semantic_map import SemanticMap
from ucon.perception.viewpoints import Costs, Expectation


@dataclass(frozen=True)
class CoverageWeights:
    """Mass of one thing's top, inside, space below and surroundings, and of a square metre."""

    ontop: float = 1.0
    inside: float = 1.0
    """Behind doors."""
    inside_open: float = 0.5
    """In open shelves, baskets, bowls."""
    under: float = 0.3
    nextto: float = 0.6
    nextto_small: float = 0.3
    unknown: float = 0.8
    """Unexplored."""
    near: float = 0.15
    """Seen from too far to have shown the target."""


class Indifferent:
    """Expects the target anywhere that has room for it."""

    def __init__(self, target: str, weights: CoverageWeights) -> None:
        self._target, self._weights = target, weights
        self._mass = np.zeros((0, 4))
        self._named = 0

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :class:`models.agents.search.Expecting`."""
        n = known.n_tracks
        if n > len(self._mass):
            grown = np.zeros((n, 4))
            grown[: len(self._mass)] = self._mass
            for track in range(len(self._mass), n):
                grown[track] = self._of(known.category[track])
            self._mass = grown
        return Expectation(self._mass, self._weights.unknown, self._weights.near)

    def _of(self, category: str) -> tuple[float, float, float, float]:
        if category in ("", "floors", "walls", "ceilings"):
            return 0.0, 0.0, 0.0, 0.0
        has, w = affordance(category), self._weights
        ontop, inside, under = has_room(self._target, category)
        return (
            w.ontop * (has.ontop and ontop),
            (w.inside if has.openable else w.inside_open) * (has.inside and inside),
            w.under * (has.under and under),
            w.nextto if has.furniture else w.nextto_small,
        )


class FrontierAgent(ControllerAgent):
    """Searches by coverage alone."""

    name = "frontier"

    def __init__(self, weights: CoverageWeights | None = None, costs: Costs | None = None) -> None:
        """What coverage expects, and what actions cost."""
        super().__init__()
        self._weights = weights or CoverageWeights()
        self._costs = costs or Costs()

    def start(self, info: Info) -> Controller:
        """See :class:`models.agents.base.ControllerAgent`."""
        return SearchController(info, Indifferent(str(info["target"]), self._weights), self._costs)
