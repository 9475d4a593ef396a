"""A choice among views that is due, and the part of a search that the weighing of suspects reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.target_places import Places
from ucon.perception.views.homing import Homing
from ucon.perception.views.viewpoints import Choice, Expectation, ViewValues


@dataclass(frozen=True, eq=False)
class SearchDecision(Shared):
    """A choice among views that is due."""

    number: int
    """Number of the decision in its episode, from 0."""
    step: int
    """Step of the newest frame, from 0."""
    best: Choice | None
    """The choice by gain over cost; None where there is nowhere to go."""
    valued: ViewValues | None
    """All views; None where none has any gain, so that ``best`` is merely an unvisited node."""
    expected: Expectation
    """Expected mass of tracks, relations and space."""
    closed: NDArray[np.int64]
    """(c,) tracks of the containers that may be opened."""


class Seeking(Protocol):
    """The part of a search that others read; :class:`ucon.search.searcher.Searcher` describes the attributes."""

    target: str
    map: SemanticMap
    planner: Planner
    places: Places
    homing: Homing
    taking: bool
    expected: Expectation | None

    def decision(self) -> SearchDecision:
        """The choice among views that is due."""
        ...
