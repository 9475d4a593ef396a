"""What a reader of habits expects: belief over places, spread over the things seen and what is unexplored.

An anchor's share goes to its instances seen so far, the rest waits in unexplored space. What a frame shows empty is
lowered by the chance that it would have shown the target (:mod:`ucon.perception.places.target_places`); a flat tail
makes the search fall back to coverage once the habits are spent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.belief.coverage import Coverage
from ucon.perception.mapping.semantic_map import CELL_M, SemanticMap
from ucon.perception.places.neighbourhood import interest
from ucon.perception.places.target_places import Places, with_fallback
from ucon.perception.views.viewpoints import Expectation

#: Mass of a whole home in the units of :class:`Coverage`: what its weights come to in a home of common size.
_COVERAGE_UNITS = 450.0


@dataclass(frozen=True)
class Locations(Shared):
    """A distribution over (anchor category, relation)."""

    names: tuple[str, ...]
    p: NDArray[np.float64]
    """(A, 4) joint probability of anchor and relation (ontop, inside, under, nextto); the rest is anywhere."""
    habits: tuple[str, ...] = ()
    """The H habits that were read."""
    relevance: NDArray[np.float64] | None = None
    """(H,) how much each habit that was read is taken to say where the target is; None where none was read."""
    support: Callable[[str], NDArray[np.float64]] | None = None
    """(H,) how strongly each of them speaks for the target being by an anchor; None where none was read."""


@dataclass(frozen=True)
class BeliefWeights(Shared):
    """How belief is turned into expected mass."""

    tail: float = 0.1
    """Part of the belief that follows coverage instead of habits. On the validation set the likelihood of the true
    place is best near 0.1 at every habit level (nats a target at 0.1 / 0.3 / 1: none 4.48 / 4.56 / 5.27, retrieval
    3.94 / 3.99 / 5.27, gt 3.60 / 3.68 / 5.27)."""
    hidden: float = 0.5
    """Share of a category's belief kept, at first, for instances not seen yet."""
    exists: float = 0.5
    """Chance that a home has an anchor that was not seen yet at all."""
    home_m2: float = 130.0
    """Floor that a home is expected to have; unexplored belief is spread over what is left of it."""
    least_m2: float = 25.0
    least_share: float = 0.25
    """What is left is at least so much floor, and this share of what was explored."""


#: Of a home that is known: nothing is left unexplored, and what was not met is not there.
KNOWN_HOME: Final = BeliefWeights(hidden=0.0, exists=0.0, home_m2=0.0, least_m2=0.01, least_share=0.0)


class TargetBelief(PartlyShared):
    """Expects the target where the habits say, and a little everywhere."""

    _shared: ClassVar[frozenset[str]] = frozenset({"_mass", "_interest", "_row"})

    def __init__(self, locations: Locations, coverage: Coverage, weights: BeliefWeights) -> None:
        self._coverage, self._weights = coverage, weights
        self.locations = locations
        self._mass = np.zeros((0, 4))
        self._unseen_per_m2 = 0.0
        self._interest: NDArray[np.float32] | None = None
        self.believe(locations)

    def believe(self, locations: Locations) -> None:
        """Expect by ``locations`` from now on."""
        self._row = {name: k for k, name in enumerate(locations.names)}
        self.locations = locations
        self._anywhere = max(0.0, 1.0 - float(locations.p.sum()))
        self._seen = (-1, 0)

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :class:`ucon.perception.belief.protocol.Expecting`: habits read once stay as they were read."""
        return False

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :class:`ucon.perception.belief.protocol.Expecting`."""
        flat = self._coverage.expect(known, places)
        explored_m2 = float(np.count_nonzero(known.floor)) * CELL_M**2
        trust = 1.0 - self._weights.tail
        tail = (1.0 - trust + trust * self._anywhere) / _COVERAGE_UNITS
        anywhere = tail * flat.unknown_per_m2
        if self._seen != (known.n_tracks, int(explored_m2)):
            wanted = self._spread(known, explored_m2)
            self._seen = (known.n_tracks, int(explored_m2))
            part = trust * self._unseen_per_m2 / max(trust * self._unseen_per_m2 + anywhere, 1e-12)
            self._interest = (1.0 - part + part * interest(known, wanted)).astype(np.float32)
        unknown = trust * self._unseen_per_m2 + anywhere
        return Expectation(trust * self._mass + tail * flat.mass, unknown, tail * flat.near_per_m2, self._interest)

    def _spread(self, known: SemanticMap, explored_m2: float) -> dict[str, float]:
        """Divide every category's belief among its instances and the unexplored rest of the home; returns the rest."""
        w, p = self._weights, self.locations.p
        left_m2 = max(w.least_m2, w.home_m2 - explored_m2, w.least_share * explored_m2)
        share_left = left_m2 / (left_m2 + explored_m2)
        self._mass = np.zeros((known.n_tracks, 4))
        total, seen = float(p.sum()), 0.0
        for name, tracks in known.instances.items():
            k = self._row.get(name)
            if k is None:
                continue
            self._mass[tracks] = with_fallback(p[k] * (1.0 - w.hidden * share_left), name) / len(tracks)
            seen += float(p[k].sum())
        unseen = share_left * (w.hidden * seen + w.exists * (total - seen))
        found = float(self._mass.sum())
        scale = total / max(found + unseen, 1e-9)
        self._mass *= scale
        self._unseen_per_m2 = scale * unseen / left_m2
        return {
            name: float(p[k].sum()) * (w.hidden if name in known.instances else w.exists)
            for name, k in self._row.items()
        }
