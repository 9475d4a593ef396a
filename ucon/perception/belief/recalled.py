"""Where a memory says that the target may be, and expected mass that combines this with what the habits say."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ucon.core.sharing import PartlyShared, Shared
from ucon.objects.model import RELATIONS, Spot
from ucon.perception.belief.protocol import Expecting
from ucon.perception.belief.target_belief import Locations
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import NOTED, Places
from ucon.perception.views.viewpoints import Expectation

#: A remembered place is matched to the nearest sample point of the map, if that is no farther away than this, metres.
NEAR_M = 0.6
#: The same for points of the anchor and relation by which the place is remembered: compartments have only a few points.
OF_ANCHOR_M: Final = 1.0
#: Share of the probability of a remembered place that is at the place itself; the rest is shared by the points of its
#: anchor and relation, since people also put things near where they were.
EXACTLY: Final = 0.6
#: Sample points of two requests that are no farther apart than this are the same place, metres.
SAME_M: Final = 0.3
#: Sample points of different relations count as so far apart, metres.
_APART_M: Final = 100.0


@dataclass(frozen=True, eq=False)
class Recalled(Shared):
    """Where the target may be, as remembered.

    Attributes:
        xyz: (n, 3) places where it was seen, metres in the frame of the map.
        p: (n,) probability of each; the rest up to 1 is elsewhere.
        spots: relation and anchors of each of the n places, as far as they are known.
        looked: (m, 4) points that earlier requests looked at, see :func:`points_of`.
        left: (m,) factor, 0 to 1, by which these looks lowered the probability of each point.
        size: (n, 3) sides of what was seen at each of the n places, metres; 0 where they are not known.
    """

    xyz: NDArray[np.float64]
    p: NDArray[np.float64]
    spots: Sequence[Spot] = ()
    looked: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 4)))
    left: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    size: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        if len(self.spots) not in (0, len(self.xyz)):
            raise ValueError(f"{len(self.spots)} spots of {len(self.xyz)} places: expected one of each, or none")


def points_of(places: Places) -> NDArray[np.float64]:
    """Sample points (n, 4): x, y, z in metres, and a fourth coordinate that keeps relations apart."""
    return np.column_stack([places.xyz, _APART_M * places.relation])


def nearest(tree: cKDTree | None, to: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The point of a tree that is nearest to each of n others, and whether it is of the same place.

    Args:
        tree: of points (m, 4), see :func:`points_of`; None: no points.
        to: (n, 4) other points.

    Returns:
        Row numbers (n,) and flags (n,).
    """
    if tree is None:
        return np.zeros(len(to), np.int64), np.zeros(len(to), bool)
    away, row = tree.query(to, distance_upper_bound=SAME_M)
    same = np.isfinite(away)
    return np.where(same, row, 0), same


class Remembering(PartlyShared):
    """Expected mass from memory and, for the rest of the probability, from what is expected without memory.

    Implements :class:`ucon.perception.belief.protocol.Expecting`.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_looked"})

    def __init__(self, inner: Expecting, recalled: Recalled) -> None:
        """Combine the expected mass without memory with what is remembered.

        Args:
            inner: expected mass without memory.
            recalled: where the target was seen before, and where not.
        """
        self._inner, self._recalled = inner, recalled
        self._looked = cKDTree(recalled.looked) if len(recalled.looked) else None
        self._left = np.zeros(0)
        n = len(recalled.xyz)
        self._rows, self._like, self._of = np.full(n, -1, np.int64), np.full(n, -1, np.int64), (0, 0)

    @property
    def locations(self) -> Locations | None:
        """What was read from the habits."""
        return self._inner.locations

    def weigh(self, p: NDArray[np.float64]) -> None:
        """Set the probabilities of the remembered places.

        Args:
            p: (n,) of each; 0 for those that were 0 at the start.
        """
        self._recalled = replace(self._recalled, p=p)

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :meth:`ucon.perception.belief.protocol.Expecting.reread`."""
        return self._inner.reread(known, places)

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :meth:`ucon.perception.belief.protocol.Expecting.expect`; also divides it among the sample points."""
        found, (rows, p) = self._inner.expect(known, places), self._at(known, places)
        rest, kind = 1.0 - float(p.sum()), 4 * places.track + places.relation
        self._look_back(places)
        plain, there = rest * found.mass.ravel(), found.unit * p
        np.add.at(plain, kind[rows], (1.0 - EXACTLY) * there)
        mass = plain[kind] * places.even * self._left
        np.add.at(mass, rows, EXACTLY * there)
        places.divide(mass)
        offered = np.bincount(kind, places.even, plain.size) > 0.0
        by_kind = np.where(offered, np.bincount(kind, mass, plain.size), plain)
        return replace(
            found,
            mass=by_kind.reshape(found.mass.shape),
            unknown_per_m2=rest * found.unknown_per_m2,
            near_per_m2=rest * found.near_per_m2,
        )

    def _look_back(self, places: Places) -> None:
        """Note, for new sample points, the factor by which looks of earlier requests lowered their probability."""
        n = len(self._left)
        if len(places.xyz) > n:
            row, same = nearest(self._looked, points_of(places)[n:])
            left = np.ones(len(row))
            left[same] = self._recalled.left[row[same]]
            self._left = np.append(self._left, left)

    def _at(self, known: SemanticMap, places: Places) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Sample points that stand for remembered places on the map, and the probability of each.

        Each place has a point of its own, which is assigned to a thing near it on the map. That thing is looked up
        again when the points of the map have changed.
        """
        state = (len(places.even), int(np.count_nonzero(places.even)))
        if state != self._of:
            numbers, rows = np.flatnonzero(self._recalled.p > 0.0), np.flatnonzero(places.even > NOTED)
            away = np.linalg.norm(self._recalled.xyz[numbers, None] - places.xyz[rows][None], axis=2)
            self._prefer_anchors(away, numbers, known, places, rows)
            for number, distances in zip(numbers.tolist(), away, strict=True):
                best = int(distances.argmin()) if len(rows) else -1
                near = best >= 0 and distances[best] <= NEAR_M
                self._attach(number, int(rows[best]) if near else -1, places)
            self._of = (len(places.even), int(np.count_nonzero(places.even)))
        there = self._like >= 0
        return self._rows[there], self._recalled.p[there]

    def _attach(self, number: int, like: int, places: Places) -> None:
        """Assign the point of a place to the thing of the point ``like``; -1: the map has no thing there."""
        if like == self._like[number]:
            return
        row = int(self._rows[number])
        if like >= 0:
            self._rows[number] = places.note(self._recalled.xyz[number], like, row)
        else:
            places.drop(row)
        self._like[number] = like

    def _prefer_anchors(
        self,
        away: NDArray[np.float64],
        numbers: NDArray[np.int64],
        known: SemanticMap,
        places: Places,
        rows: NDArray[np.int64],
    ) -> None:
        """Put points of the anchor and relation by which a place is remembered before all others.

        Something in the fridge is found by opening the fridge, even if a point of another thing is nearer.

        Args:
            away: (n, k) distances of places and points, updated.
            numbers: (n,) of the places.
            known: the map.
            places: its sample points.
            rows: (k,) those that count.
        """
        if not self._recalled.spots:
            return
        for number, distances in zip(numbers.tolist(), away, strict=True):
            if not (spot := self._recalled.spots[number]):
                continue
            relation, anchor = spot[0]
            tracks = known.instances.get(anchor, ())
            of_anchor = np.isin(places.track[rows], tracks) & (places.relation[rows] == RELATIONS.index(relation))  # type: ignore[arg-type]
            distances[of_anchor & (distances <= OF_ANCHOR_M)] -= OF_ANCHOR_M


def remembering(expecting: Expecting, info: Mapping[str, Any]) -> Expecting:
    """The expected mass of a search: combined with memory, where the info at the reset has ``recalled``."""
    recalled = info.get("recalled")
    return expecting if recalled is None else Remembering(expecting, recalled)
