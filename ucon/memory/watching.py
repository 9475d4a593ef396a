"""Which of the remembered places the frames of a request show, and at which of them something stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.memory.sighting_log import SightingLog
from ucon.perception.mapping.map_kernels import look
from ucon.perception.mapping.semantic_map import SemanticMap, camera_of
from ucon.perception.places.affordances import sight_range_m
from ucon.perception.places.hollows import ALL_OPEN
from ucon.perception.places.occupied import Occupied


class Watching:
    """Tracks the remembered places during one request."""

    def __init__(self, log: SightingLog) -> None:
        """Start with nothing shown.

        Args:
            log: the remembered places.
        """
        things = log.things
        self._of = [(name, place) for name, thing in things.items() for place in range(len(thing.places))]
        n = len(self._of)
        self._xyz = np.concatenate([np.zeros((0, 3)), *(thing.places for thing in things.values())])
        self._reach_m, self._unshown = np.array([sight_range_m(name) for name, _ in self._of]), np.ones(n)
        self._hollow, self._faces = np.zeros((n, 6)), np.full(n, ALL_OPEN, np.uint8)
        size = np.concatenate([np.zeros((0, 3)), *(thing.size for thing in things.values())])
        self._occupied = Occupied(self._xyz, size, [spot for thing in things.values() for spot in thing.spots])

    def look(self, known: SemanticMap, depth: NDArray[np.float32]) -> None:
        """Take in a frame.

        Args:
            known: the map, updated with the frame.
            depth: (H, W), metres.
        """
        camera = camera_of(known.view, depth, known.body)
        active = (self._unshown > 0.0) & (depth_along(self._xyz, camera) <= self._reach_m)
        if known.hypotheses is not None:
            self._occupied.look(known, depth)
            active &= self._occupied.open
        if active.any():
            look(depth, camera, np.inf, self._xyz, self._hollow, self._faces, active, self._unshown, 0.0)

    @property
    def stands(self) -> set[tuple[str, int]]:
        """Thing and number of the places where something stands, whatever it is; none with an exact detector."""
        return {self._of[row] for row in np.flatnonzero(self._occupied.stands).tolist()}

    @property
    def shown(self) -> list[tuple[str, int]]:
        """Thing and number of the places that were shown."""
        return [self._of[row] for row in np.flatnonzero(self._unshown == 0.0).tolist()]


def depth_along(xyz: NDArray[np.float64], camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Optical depth (n,) of points (n, 3) before a camera (8,), metres; below 0 behind it."""
    x, y, z, c, s, cp, sp, _ = camera
    return np.asarray(cp * (c * (xyz[:, 0] - x) + s * (xyz[:, 1] - y)) + sp * (xyz[:, 2] - z))
