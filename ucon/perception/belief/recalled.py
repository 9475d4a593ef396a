"""What a memory says of the target's place, and a search that uses it beside what it reads from habits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.belief.protocol import Expecting
from ucon.perception.belief.target_belief import Locations
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

#: A remembered place is where the nearest sample point of the map is, if that is not farther off, metres.
NEAR_M = 0.6
#: So much of the probability of a remembered place is at that point; the rest is shared by the points of its anchor and
#: relation, since people put things near where they were, too.
EXACTLY: Final = 0.2
#: Sample points of two requests are of one place within this, metres.
SAME_M: Final = 0.3
#: Sample points of different relations count as so far apart, metres.
_APART_M: Final = 100.0


@dataclass(frozen=True, eq=False)
class Recalled(Shared):
    """Where the target may be, as remembered.

    Attributes:
        xyz: (n, 3) places where it was seen, metres in the frame of the map.
        p: (n,) probability of each; what is missing to 1 is elsewhere.
        looked: (m, 4) points that earlier requests looked at, see :func:`points_of`.
        left: (m,) what is left there, 0 to 1, of the probability of a place that was not looked at.
    """

    xyz: NDArray[np.float64]
    p: NDArray[np.float64]
    looked: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 4)))
    left: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))


def points_of(places: Places) -> NDArray[np.float64]:
    """Sample points (n, 4): x, y, z in metres, and a fourth coordinate that keeps relations apart."""
    return np.column_stack([places.xyz, _APART_M * places.relation])


def nearest(tree: cKDTree | None, to: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The point (of a tree; None: of none) that is nearest to each of others (n), and whether it is of the same place.

    Args:
        tree: of points (m, 4), see :func:`points_of`.
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
    """Expected mass by memory where there is one, and for the rest by what was expected without it.

    Implements :class:`ucon.perception.belief.protocol.Expecting`.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_looked"})

    def __init__(self, inner: Expecting, recalled: Recalled) -> None:
        """Combine both.

        Args:
            inner: expected mass without memory.
            recalled: where the target was seen before, and where not.
        """
        self._inner, self._recalled = inner, recalled
        self._looked = cKDTree(recalled.looked) if len(recalled.looked) else None
        self._left = np.zeros(0)
        self._rows, self._p, self._of = np.zeros(0, np.int64), np.zeros(0), (0, 0)

    @property
    def locations(self) -> Locations | None:
        """What was read from the habits."""
        return self._inner.locations

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :meth:`ucon.perception.belief.protocol.Expecting.reread`."""
        return self._inner.reread(known, places)

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :meth:`ucon.perception.belief.protocol.Expecting.expect`; divides it among the sample points, too."""
        found, (rows, p) = self._inner.expect(known, places), self._at(places)
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
        """What earlier looks left of the sample points that are new."""
        n = len(self._left)
        if len(places.xyz) > n:
            row, same = nearest(self._looked, points_of(places)[n:])
            left = np.ones(len(row))
            left[same] = self._recalled.left[row[same]]
            self._left = np.append(self._left, left)

    def _at(self, places: Places) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Sample points that stand for the remembered places that the map has, and the probability of each.

        Points are added or replaced, and never move: found anew only where there are others.
        """
        state = (len(places.even), int(np.count_nonzero(places.even)))
        if state != self._of and len(self._recalled.xyz):
            rows = np.flatnonzero(places.even > 0.0)
            away = np.linalg.norm(self._recalled.xyz[:, None] - places.xyz[rows][None], axis=2)
            first = away.argmin(1)
            near = away[np.arange(len(first)), first] <= NEAR_M
            self._rows, self._p, self._of = rows[first[near]], self._recalled.p[near], state
        return self._rows, self._p


def remembering(expecting: Expecting, info: Mapping[str, Any]) -> Expecting:
    """The expected mass of a search: by memory too, where the reset's info has ``recalled``."""
    recalled = info.get("recalled")
    return expecting if recalled is None else Remembering(expecting, recalled)
