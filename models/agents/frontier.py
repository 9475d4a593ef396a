"""``frontier``: explores the nearest unknown, looks at what it passes, opens what is closed. Reads no habits."""

from __future__ import annotations

import numpy as np

from models.agents.base import Controller, ControllerAgent, Info
from models.agents.search import SearchController
from ucon.perception.places import INSIDE, NEXTTO, ONTOP, UNDER, Places, affordance
from ucon.perception.semantic_map import SemanticMap
from ucon.perception.viewpoints import Costs, Expectation


class Indifferent:
    """Expects the target anywhere that can hold it, whatever the target is."""

    def __init__(self, ontop: float, inside: float, under: float, nextto: float, unknown: float, near: float) -> None:
        self._kinds = {ONTOP: ontop, INSIDE: inside, UNDER: under, NEXTTO: nextto}
        self._unknown, self._near = unknown, near
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
        return Expectation(self._mass, self._unknown, self._near)

    def _of(self, category: str) -> tuple[float, float, float, float]:
        if category in ("", "floors", "walls", "ceilings"):
            return 0.0, 0.0, 0.0, 0.0
        has = affordance(category)
        return (
            self._kinds[ONTOP] * has.ontop,
            self._kinds[INSIDE] * has.inside,
            self._kinds[UNDER] * has.under,
            self._kinds[NEXTTO] * (1.0 if has.furniture else 0.5),
        )


class FrontierAgent(ControllerAgent):
    """Searches by coverage alone."""

    name = "frontier"

    def __init__(
        self,
        ontop: float = 1.0,
        inside: float = 1.0,
        under: float = 0.3,
        nextto: float = 0.6,
        unknown: float = 0.8,
        near: float = 0.15,
        turn: float = 0.6,
        overhead: float = 2.0,
    ) -> None:
        """Weights of the relations for each thing, of unexplored and barely seen square metres, and of costs."""
        super().__init__()
        self._weights = (ontop, inside, under, nextto, unknown, near)
        self._costs = Costs(overhead=overhead, turn=turn)

    def start(self, info: Info) -> Controller:
        """See :class:`models.agents.base.ControllerAgent`."""
        return SearchController(info, Indifferent(*self._weights), self._costs)
