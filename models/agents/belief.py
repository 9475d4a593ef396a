"""``belief``: reads the habits once, spreads its belief over the things it sees, searches by probability over cost.

The reader says how probable each category is as the target's anchor, and by which relation. An anchor's share goes to
its instances seen so far, the rest waits in unexplored space. What a frame shows empty is lowered by the chance that
it would have shown the target; a flat tail makes the search fall back to coverage once the habits are spent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from models.agents.base import Controller, ControllerAgent, Info
from models.agents.frontier import CoverageWeights, Indifferent
from models.agents.search import SearchController
from ucon.perception.neighbourhood import interest
from ucon.perception.places import Places, with_fallback
from ucon.perception.semantic_map import CELL_M, SemanticMap
from ucon.perception.viewpoints import Costs, Expectation
from ucon.retrieval.reader import AnchorReader, default_reader


@dataclass(frozen=True)
class Locations:
    """A distribution over (anchor category, relation)."""

    names: tuple[str, ...]
    p: NDArray[np.float64]
    """(A, 4) joint probability of anchor and relation (ontop, inside, under, nextto); the rest is anywhere."""


#: Says where the target of an episode may be, from the info at its reset.
Locate = Callable[[Info], Locations]


class ReadHabits:
    """Locations by the anchor reader: common sense, and what the given habits say."""

    def __init__(self, reader: AnchorReader | None = None) -> None:
        self._reader = reader

    def __call__(self, info: Info) -> Locations:
        """Read ``info["habits"]`` about ``info["target"]``; at level ``gt`` all of them are about it."""
        if self._reader is None:
            self._reader = default_reader()
        trusted = info.get("habit_level") == "gt"
        reading = self._reader.read(str(info["target"]), tuple(info["habits"]), trusted=trusted)
        belief = reading.belief(self._reader.known)
        return Locations(belief.candidates, belief.p[:, None] * belief.relation)


@dataclass(frozen=True)
class BeliefWeights:
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


class Believing:
    """Expects the target where the habits say, and a little everywhere."""

    def __init__(self, locations: Locations, coverage: Indifferent, weights: BeliefWeights) -> None:
        self._coverage, self._weights = coverage, weights
        self._mass = np.zeros((0, 4))
        self._unseen_per_m2 = 0.0
        self._interest: NDArray[np.float32] | None = None
        self._believe(locations)

    def _believe(self, locations: Locations) -> None:
        self._row = {name: k for k, name in enumerate(locations.names)}
        self._locations = locations
        self._anywhere = max(0.0, 1.0 - float(locations.p.sum()))
        self._seen = (-1, 0)

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :class:`models.agents.search.Expecting`: habits read once stay as they were read."""
        return False

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :class:`models.agents.search.Expecting`."""
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
        w, p = self._weights, self._locations.p
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


class Rereading(Believing):
    """At habit level ``context``: says what it saw, and reads the list that comes of it."""

    def __init__(
        self, locations: Locations, coverage: Indifferent, weights: BeliefWeights, info: Info, locate: Locate
    ) -> None:
        super().__init__(locations, coverage, weights)
        self._info, self._locate = dict(info), locate

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """See :class:`models.agents.search.Expecting`."""
        ranking = self._info["reranking"]
        if not ranking.update(known.instances.keys() & self._row.keys(), self._emptied(known, places)):
            return False
        self._believe(self._locate(self._info | {"habits": ranking.texts}))
        return True

    def _emptied(self, known: SemanticMap, places: Places) -> dict[str, float]:
        """Share of each category's belief that was looked at in vain, in tenths: less makes no new list."""
        n = known.n_tracks
        left = np.bincount(places.track, places.weights(self._mass), n)
        whole = np.bincount(places.track, self._mass[places.track, places.relation] * places.share, n)
        out: dict[str, float] = {}
        for name, tracks in known.instances.items():
            total = float(whole[tracks].sum())
            if name in self._row and total > 0.0:
                out[name] = round(1.0 - float(left[tracks].sum()) / total, 1)
        return {name: share for name, share in out.items() if share > 0.0}


#: Mass of a whole home in the units of :class:`Indifferent`: what its weights come to in a home of common size.
_COVERAGE_UNITS = 450.0


class BeliefAgent(ControllerAgent):
    """Searches by what the habits say."""

    name = "belief"

    def __init__(
        self,
        locate: Locate | None = None,
        weights: BeliefWeights | None = None,
        coverage: CoverageWeights | None = None,
        costs: Costs | None = None,
    ) -> None:
        """``locate``: gives the distribution over places; by default it is read from the habits."""
        super().__init__()
        self._locate = locate or ReadHabits()
        self._weights = weights or BeliefWeights()
        self._coverage = coverage or CoverageWeights()
        self._costs = costs or Costs()

    def start(self, info: Info) -> Controller:
        """See :class:`models.agents.base.ControllerAgent`."""
        coverage = Indifferent(str(info["target"]), self._coverage)
        locations = self._locate(info)
        if "reranking" in info:
            believing: Believing = Rereading(locations, coverage, self._weights, info, self._locate)
        else:
            believing = Believing(locations, coverage, self._weights)
        return SearchController(info, believing, self._costs)
