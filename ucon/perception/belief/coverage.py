"""Expected target mass by coverage alone: every place that has room for the target, whatever the target is.

The agent ``frontier`` searches by this; ``belief`` falls back to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.affordances import Kind, affordance, has_room
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

#: Sum of the coverage weights over a home of common size.
COVERAGE_UNITS = 450.0


class PlaceWeights(NamedTuple):
    """Weight of each relation to one thing, by the kind of the thing.

    Unit of all five: the weight of the top of a piece of fixed furniture is 1. ``inside_closed`` is for things with
    doors or drawers, ``inside_open`` for things without.
    """

    ontop: float
    inside_closed: float
    inside_open: float
    under: float
    nextto: float


def _by_kind() -> dict[Kind, PlaceWeights]:
    """The fitted weights, by kind of thing; see :class:`CoverageWeights` for the fit."""
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
    """How often targets are in each kind of place, whatever the target is.

    Unit of all weights: the top of a piece of fixed furniture is 1. ``things`` are maximum likelihood estimates from
    the 400 episodes of the validation set. The model of that fit: the target is at one of the things of its home,
    chosen in proportion to their weights. All things of a home together weigh 3.4 per square metre of its floor.
    """

    things: Mapping[Kind, PlaceWeights] = field(default_factory=_by_kind)
    unknown: float = 3.4
    """Weight of a square metre of floor that was not explored yet."""
    near: float = 0.3
    """Weight of a square metre that was seen, but from too far away to have shown the target."""


class Coverage(PartlyShared):
    """Expected target mass without habits: anywhere that has room for the target.

    Implements :class:`ucon.perception.belief.protocol.Expecting`.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_mass"})

    #: No habits are read, so there is no distribution over anchors.
    locations = None

    def __init__(self, target: str, weights: CoverageWeights) -> None:
        """Start with an empty map.

        Args:
            target: category of the target, for its size.
            weights: weight of every kind of place.
        """
        self._target, self._weights = target, weights
        self._mass = np.zeros((0, 4))
        self._named = -1

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """Expected mass of everything on the map, in units of :class:`CoverageWeights`.

        Args:
            known: the map, with T tracks.
            places: not used; what was looked at is taken into account when views are valued.

        Returns:
            ``mass`` (T, 4) float64 by track and relation, and the weights per square metre of unexplored and far space.
        """
        n = known.n_tracks
        if n > len(self._mass):
            grown = np.zeros((n, 4))
            grown[: len(self._mass)] = self._mass
            for track in range(len(self._mass), n):
                grown[track] = self._relation_weights(known.category[track])
            self._mass = grown
        renamed = np.flatnonzero(known.named_at[:n] > self._named).tolist()
        if renamed:
            self._mass = self._mass.copy()
            self._mass[renamed] = [self._relation_weights(known.category[track]) for track in renamed]
        self._named = known.step
        return Expectation(self._mass, self._weights.unknown, self._weights.near, unit=COVERAGE_UNITS)

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Always False: coverage reads no habits."""
        return False

    def _relation_weights(self, category: str) -> tuple[float, float, float, float]:
        """Weight of one thing's relations (ontop, inside, under, nextto); 0 where it has no room for the target."""
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
