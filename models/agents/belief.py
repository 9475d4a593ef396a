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
from ucon.perception.places import Places, with_fallback
from ucon.perception.semantic_map import CELL_M, SemanticMap
from ucon.perception.viewpoints import Costs, Expectation
from ucon.retrieval.reader import AnchorReader


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
            self._reader = AnchorReader()
        trusted = info.get("habit_level") == "gt"
        reading = self._reader.read(str(info["target"]), tuple(info["habits"]), trusted=trusted)
        belief = reading.belief(self._reader.known)
        return Locations(belief.candidates, belief.p[:, None] * belief.relation)


@dataclass(frozen=True)
class BeliefWeights:
    """How belief is turned into expected mass."""

    tail: float = 0.3
    """Part of the belief that follows coverage instead of habits."""
    hidden: float = 0.35
    """Share of a category's belief kept, at first, for instances not seen yet."""
    home_m2: float = 110.0
    """Floor that a home is expected to have; unexplored belief is spread over what is left of it."""
    least_m2: float = 25.0


class Believing:
    """Expects the target where the habits say, and a little everywhere."""

    def __init__(self, locations: Locations, coverage: Indifferent, weights: BeliefWeights) -> None:
        self._row = {name: k for k, name in enumerate(locations.names)}
        self._locations, self._coverage, self._weights = locations, coverage, weights
        self._anywhere = max(0.0, 1.0 - float(locations.p.sum()))
        self._seen = (-1, 0)
        self._mass = np.zeros((0, 4))
        self._unseen = 1.0

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """See :class:`models.agents.search.Expecting`."""
        flat = self._coverage.expect(known, places)
        explored_m2 = float(np.count_nonzero(known.floor)) * CELL_M**2
        if self._seen != (known.n_tracks, int(explored_m2)):
            self._spread(known, explored_m2)
            self._seen = (known.n_tracks, int(explored_m2))
        w = self._weights
        left_m2 = max(w.least_m2, w.home_m2 - explored_m2)
        tail = (w.tail + (1.0 - w.tail) * self._anywhere) / _COVERAGE_UNITS
        unknown = (1.0 - w.tail) * self._unseen / left_m2 + tail * flat.unknown_per_m2
        return Expectation((1.0 - w.tail) * self._mass + tail * flat.mass, unknown, tail * flat.near_per_m2)

    def _spread(self, known: SemanticMap, explored_m2: float) -> None:
        """Divide every category's belief among its instances and the unexplored rest of the home."""
        w = self._weights
        share_left = max(0.0, 1.0 - explored_m2 / w.home_m2)
        self._mass = np.zeros((known.n_tracks, 4))
        seen = 0.0
        for name, tracks in known.instances.items():
            k = self._row.get(name)
            if k is None:
                continue
            here = self._locations.p[k] * (1.0 - w.hidden * share_left)
            self._mass[tracks] = with_fallback(here, name) / len(tracks)
            seen += float(here.sum())
        self._unseen = (float(self._locations.p.sum()) - seen) * share_left


#: Mass of a whole home in the units of :class:`Indifferent`: what its weights come to in a home of common size.
_COVERAGE_UNITS = 250.0


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
        return SearchController(info, Believing(self._locate(info), coverage, self._weights), self._costs)
