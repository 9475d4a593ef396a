"""Closed containers among the things seen, and those that an Open from the current pose would reach."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.affordances import affordance

#: Taken off the reach of Open, metres: the box of what was seen may be smaller than the container.
_MARGIN_M = 0.02


def open_reach_m(known: SemanticMap) -> float:
    """How near the seen part of a container must be to a node for Open to reach it from there, in metres."""
    return known.body.near_m - _MARGIN_M - known.body.off_node_m


def _opens(name: str) -> bool:
    """Whether things of a name open; "" is no thing."""
    return bool(name) and affordance(name).openable


class Containers(PartlyShared):
    """The containers of one episode. Whether a category opens is read from the catalogue."""

    _shared: ClassVar[frozenset[str]] = frozenset({"_openable"})

    def __init__(self) -> None:
        self._openable = np.zeros(0, bool)
        self._named = -1

    def closed(self, known: SemanticMap) -> NDArray[np.int64]:
        """Tracks of containers that were not opened yet and of which at least one point was seen.

        Returns:
            (n,) int64, ascending.
        """
        n = known.n_tracks
        fresh = range(len(self._openable), n)
        named = np.flatnonzero(known.named_at[:n] > self._named).tolist()
        if fresh or named:
            more = np.array([_opens(known.category[track]) for track in fresh], bool)
            self._openable = np.concatenate([self._openable, more])
            self._openable[named] = [_opens(known.category[track]) for track in named]
        self._named = known.step
        shut = self._openable & ~known.opened[:n]
        return np.flatnonzero(shut & (known.box[:n, 3] >= known.box[:n, 0]))

    def in_reach(self, known: SemanticMap) -> list[int]:
        """Tracks of closed containers that Open would open now: in view and within reach, according to the map."""
        reach_m = known.body.near_m - _MARGIN_M
        return [
            int(track)
            for track in self.closed(known)
            if known.pixels[track] >= MIN_PIXELS and known.gap_now_m(int(track)) <= reach_m
        ]
