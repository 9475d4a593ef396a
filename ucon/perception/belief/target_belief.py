"""The belief about the target's place: a distribution over anchors, spread over the things seen and unexplored space.

The probability of an anchor category goes to its instances seen so far; the rest waits in unexplored space. A frame
that shows a place empty lowers it by the chance that the frame would have shown the target
(:mod:`ucon.perception.places.target_places`). A flat tail follows coverage, so that the search goes on once every place
that the habits name was searched.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.belief.coverage import COVERAGE_UNITS, Coverage
from ucon.perception.hypotheses.hypotheses import Hypotheses
from ucon.perception.mapping.semantic_map import CELL_M, SemanticMap
from ucon.perception.places.affordances import with_fallback
from ucon.perception.places.neighbourhood import interest
from ucon.perception.places.target_places import Places
from ucon.perception.views.viewpoints import Expectation

#: Names that a thing has with less than this probability are left out.
_LEAST_NAME = 0.05


@dataclass(frozen=True)
class Locations(Shared):
    """A joint distribution over anchor category and relation for one target."""

    names: tuple[str, ...]
    """The A anchor categories."""
    p: NDArray[np.float64]
    """(A, 4) joint probability of anchor and relation (ontop, inside, under, nextto). Sums to 1 or less; the remainder
    is the probability of a place that is none of these."""
    habits: tuple[str, ...] = ()
    """The H habits that were read."""
    relevance: NDArray[np.float64] | None = None
    """(H,) in [0, 1], how much each habit says about where the target is; None where no habit was read."""
    support: Callable[[str], NDArray[np.float64]] | None = None
    """From an anchor category to (H,) in [0, 1], how strongly each habit supports that anchor; None where no habit
    was read."""


@dataclass(frozen=True)
class BeliefWeights(Shared):
    """How a distribution over anchors is spread over the map."""

    tail: float = 0.1
    """Part of the belief that follows coverage instead of habits. On the validation set the likelihood of the true
    place is best near 0.1 at every habit level (nats a target at 0.1 / 0.3 / 1: none 4.48 / 4.56 / 5.27, retrieval
    3.94 / 3.99 / 5.27, gt 3.60 / 3.68 / 5.27)."""
    hidden: float = 0.5
    """Share of an anchor category's probability that waits for further instances, while nothing is explored yet."""
    exists: float = 0.5
    """Probability that the home has an anchor category of which no instance was seen yet."""
    home_m2: float = 130.0
    """Expected floor of a home in square metres; unexplored mass is spread over the part not explored yet."""
    least_m2: float = 25.0
    """The unexplored part is taken to be at least this many square metres."""
    least_share: float = 0.25
    """The unexplored part is taken to be at least this share of the explored part."""


#: Weights for a home that was toured before the search: nothing is unexplored, and anchors not seen do not exist.
KNOWN_HOME: Final = BeliefWeights(hidden=0.0, exists=0.0, home_m2=0.0, least_m2=0.01, least_share=0.0)


class TargetBelief(PartlyShared):
    """Expected mass by the habits' distribution, with a flat tail by coverage.

    Implements :class:`ucon.perception.belief.protocol.Expecting`.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_mass", "_interest", "_row", "_p"})

    def __init__(self, locations: Locations, coverage: Coverage, weights: BeliefWeights) -> None:
        """Start with an empty map.

        Args:
            locations: the distribution over anchors and relations.
            coverage: expected mass without habits, for the tail.
            weights: how the distribution is spread over the map.
        """
        self._coverage, self._weights = coverage, weights
        self.locations = locations
        self._mass = np.zeros((0, 4))
        self._unseen_per_m2 = 0.0
        self._interest: NDArray[np.float32] | None = None
        self.believe(locations)

    def believe(self, locations: Locations) -> None:
        """Replace the distribution over anchors and relations; the next :meth:`expect` uses it."""
        self._row = {name: k for k, name in enumerate(locations.names)}
        self._p = np.array([float(p.sum()) for p in locations.p])
        self.locations = locations
        self._anywhere = max(0.0, 1.0 - float(locations.p.sum()))
        self._seen = (-1, 0, -1)

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Always False: habits are read once. :class:`ucon.perception.belief.from_habits.ContextBelief` reads again."""
        return False

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """Expected mass, given the map so far; see :meth:`ucon.perception.belief.protocol.Expecting.expect`.

        The unit is probability: all mass of a home of common size comes to about 1. What was seen of the places is not
        yet taken into account (:meth:`ucon.perception.places.target_places.Places.weights` does that).

        Returns:
            ``mass`` (T, 4), mass per square metre of unexplored and of far space, and ``interest``, (257, 257) float32
                factors of unexplored cells.
        """
        flat = self._coverage.expect(known, places)
        explored_m2 = float(np.count_nonzero(known.floor)) * CELL_M**2
        trust = 1.0 - self._weights.tail
        tail = (1.0 - trust + trust * self._anywhere) / COVERAGE_UNITS
        anywhere = tail * flat.unknown_per_m2
        state = (known.n_tracks, int(explored_m2), int(known.named_at[: known.n_tracks].max(initial=-1)))
        if self._seen != state:
            wanted = self._spread(known, explored_m2)
            self._seen = state
            part = trust * self._unseen_per_m2 / max(trust * self._unseen_per_m2 + anywhere, 1e-12)
            around = interest(known, self.locations.names, wanted)
            self._interest = (1.0 - part + part * around).astype(np.float32)
        unknown = trust * self._unseen_per_m2 + anywhere
        return Expectation(trust * self._mass + tail * flat.mass, unknown, tail * flat.near_per_m2, self._interest)

    def _spread(self, known: SemanticMap, explored_m2: float) -> NDArray[np.float64]:
        """Divide each category's probability among its instances and the unexplored part of the home.

        Writes ``_mass`` (T, 4) and ``_unseen_per_m2``.

        Returns:
            (A,) by category, the probability that waits in unexplored space (not normalised).
        """
        w, p = self._weights, self.locations.p
        left_m2 = max(w.least_m2, w.home_m2 - explored_m2, w.least_share * explored_m2)
        share_left = left_m2 / (left_m2 + explored_m2)
        self._mass = np.zeros((known.n_tracks, 4))
        total, seen = float(p.sum()), 0.0
        found_names = [name for name in known.instances if name in self._row]
        rows = [self._row[name] for name in found_names]
        if known.hypotheses is not None:
            seen = self._among_hypotheses(known, known.hypotheses, 1.0 - w.hidden * share_left)
        elif rows:
            spread = with_fallback(p[rows] * (1.0 - w.hidden * share_left), found_names)
            tracks = [known.instances[name] for name in found_names]
            count = np.array([len(of) for of in tracks])
            self._mass[np.concatenate(tracks)] = np.repeat(spread / count[:, None], count, axis=0)
            seen = sum(self._p[rows].tolist())
        unseen = share_left * (w.hidden * seen + w.exists * (total - seen))
        found = float(self._mass.sum())
        scale = total / max(found + unseen, 1e-9)
        self._mass *= scale
        self._unseen_per_m2 = scale * unseen / left_m2
        waiting = np.full(len(p), w.exists)
        waiting[rows] = w.hidden
        return waiting * self._p

    def _among_hypotheses(self, known: SemanticMap, hypotheses: Hypotheses, part: float) -> float:
        """Divide ``part`` of each category's probability among the things that may be of it.

        Writes ``_mass``. Returns the probability of the categories that were probably seen.
        """
        p = self.locations.p
        called = hypotheses.named(self.locations.names, known.n_tracks)
        called[called < _LEAST_NAME] = 0.0
        count = called.sum(0)
        self._mass = part * (called / np.maximum(count, 1.0)) @ p
        tracks = np.flatnonzero(self._mass.any(1))
        names = [known.category[track] for track in tracks.tolist()]
        self._mass[tracks] = with_fallback(self._mass[tracks], names)
        self._mass[[track for track, name in zip(tracks.tolist(), names, strict=True) if not name]] = 0.0
        return float(np.minimum(count, 1.0) @ p.sum(1))
