"""What a memory says of the target's place, and a search that uses it beside what it reads from habits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.belief.protocol import Expecting
from ucon.perception.belief.target_belief import Locations
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

#: A remembered place is where the nearest sample point of the map is, if that is not farther off, metres.
NEAR_M = 0.6


@dataclass(frozen=True, eq=False)
class Recalled(Shared):
    """Places where the target may be, as remembered.

    Attributes:
        xyz: (n, 3) points, metres in the frame of the map.
        p: (n,) probability of each; what is missing to 1 is elsewhere.
    """

    xyz: NDArray[np.float64]
    p: NDArray[np.float64]


class Remembering(PartlyShared):
    """Expected mass by memory where there is one, and for the rest by what was expected without it.

    Implements :class:`ucon.perception.belief.protocol.Expecting`.
    """

    def __init__(self, inner: Expecting, recalled: Recalled) -> None:
        """Combine both.

        Args:
            inner: expected mass without memory.
            recalled: where the target was seen before.
        """
        self._inner, self._recalled = inner, recalled

    @property
    def locations(self) -> Locations | None:
        """What was read from the habits."""
        return self._inner.locations

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :meth:`ucon.perception.belief.protocol.Expecting.reread`."""
        return self._inner.reread(known, places)

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :meth:`ucon.perception.belief.protocol.Expecting.expect`."""
        found, (tracks, relations, p) = self._inner.expect(known, places), self._at(known, places)
        rest = 1.0 - float(p.sum())
        mass = rest * found.mass
        np.add.at(mass, (tracks, relations), found.unit * p)
        return replace(
            found,
            mass=mass,
            unknown_per_m2=rest * found.unknown_per_m2,
            near_per_m2=rest * found.near_per_m2,
        )

    def _at(
        self, known: SemanticMap, places: Places
    ) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float64]]:
        """Track, relation and probability of the remembered places that the map has."""
        rows = np.flatnonzero(places.share > 0.0)
        if not len(rows):
            return np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0)
        away = np.linalg.norm(self._recalled.xyz[:, None] - places.xyz[rows][None], axis=2)
        nearest = away.argmin(1)
        near = away[np.arange(len(nearest)), nearest] <= NEAR_M
        of = rows[nearest[near]]
        return places.track[of], places.relation[of], self._recalled.p[near]


def remembering(expecting: Expecting, info: Mapping[str, Any]) -> Expecting:
    """The expected mass of a search: by memory too, where the reset's info has ``recalled``."""
    recalled = info.get("recalled")
    return expecting if recalled is None else Remembering(expecting, recalled)
