"""What coverage expects: the target anywhere that has room for it, without regard to what it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Kind, Places, affordance, has_room
from ucon.perception.views.viewpoints import Expectation


class PlaceWeights(NamedTuple):
    """Mass of one thing's top, inside behind doors, inside otherwise, space below and surroundings."""

    ontop: float
    inside_closed: float
    inside_open: float
    under: float
    nextto: float


def _by_kind() -> dict[Kind, PlaceWeights]:
    return {
        "fixed_furniture": PlaceWeights(1.0, 5.0, 0.3, 0.6, 0.9),
        "movable_furniture": PlaceWeights(3.0, 5.0, 0.75, 0.6, 1.1),
        "fixture": PlaceWeights(1.8, 5.0, 0.35, 3.0, 4.9),
        "wall": PlaceWeights(0.3, 5.0, 0.3, 0.03, 0.65),
        "ceiling": PlaceWeights(0.0, 0.0, 0.0, 0.0, 0.03),
        "movable": PlaceWeights(1.3, 4.0, 5.0, 0.6, 0.35),
        "structure": PlaceWeights(0.0, 0.0, 0.0, 0.0, 0.0),
    }


@dataclass(frozen=True)
class CoverageWeights(Shared):
    """How often targets are where, without regard to what they are; the top of a fixed piece of furniture is 1.

    The weights of things are maximum likelihood estimates (a target is by one of the things of its home, in proportion
    to their weights) from the 400 episodes of the validation set, where a home's things come to 3.4 a square metre.
    """

    things: Mapping[Kind, PlaceWeights] = field(default_factory=_by_kind)
    unknown: float = 3.4
    """A square metre not explored yet."""
    near: float = 0.3
    """A square metre seen from too far to have shown the target."""


class Coverage(PartlyShared):
    """Expects the target anywhere that has room for it."""

    _shared: ClassVar[frozenset[str]] = frozenset({"_mass"})

    #: It reads nothing.
    locations = None

    def __init__(self, target: str, weights: CoverageWeights) -> None:
        self._target, self._weights = target, weights
        self._mass = np.zeros((0, 4))
        self._named = 0

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :class:`ucon.perception.belief.protocol.Expecting`."""
        n = known.n_tracks
        if n > len(self._mass):
            grown = np.zeros((n, 4))
            grown[: len(self._mass)] = self._mass
            for track in range(len(self._mass), n):
                grown[track] = self._of(known.category[track])
            self._mass = grown
        return Expectation(self._mass, self._weights.unknown, self._weights.near)

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """It reads nothing."""
        return False

    def _of(self, category: str) -> tuple[float, float, float, float]:
        if category in ("", "floors", "walls", "ceilings"):
            return 0.0, 0.0, 0.0, 0.0
        has = affordance(category)
        w = self._weights.things[has.kind]
        ontop, inside, under = has_room(self._target, category)
        return (
            w.ontop * (has.ontop and ontop),
            (w.inside_closed if has.openable else w.inside_open) * (has.inside and inside),
            w.under * (has.under and under),
            w.nextto,
        )
