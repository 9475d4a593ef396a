"""What a robot that moves continuously steers around: obstacles on a grid of 5 cm, from its own depth images.

The grid has the frame and the centre of the 0.25 m map. A cell is an obstacle where two points at the robot's height
fell into it, seen from within the reliable range of a depth camera, or where a move was blocked. Floor points in a cell
count against an obstacle that was seen there: it was noise, or has moved.
"""

from __future__ import annotations

import math
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.perception.mapping import obstacle_kernels as kernels
from ucon.perception.mapping.map_kernels import RADIUS_M
from ucon.perception.mapping.obstacle_kernels import FINE_M, HALF, SIZE

#: A thing that blocked a move is taken to be this far ahead of the robot's middle, metres.
_BUMP_M: Final = 0.25
_BUMPED: Final = 255


class ObstacleMap(PartlyShared):
    """Obstacles that one robot saw or bumped into in one episode.

    Attributes:
        votes: (1285, 1285) uint8 by cell of 5 cm, how surely there is an obstacle; 255 where a move was blocked.
    """

    def __init__(self) -> None:
        """Start without obstacles."""
        self.votes = np.zeros((SIZE, SIZE), np.uint8)
        self._bounds = np.array([HALF, HALF, HALF, HALF])

    def add(self, depth: NDArray[np.float32], camera: NDArray[np.float64]) -> None:
        """Add one frame.

        Args:
            depth: (H, W) float32, metres along the optical axis, 0 where there is no reading.
            camera: (8,) float64 of :func:`ucon.perception.mapping.semantic_map.camera_of`.
        """
        kernels.vote(depth, camera, self.votes)
        reach = int(kernels.SURE_M * math.sqrt(2.0) / FINE_M) + 1
        self._include(*kernels.cell(camera[0], camera[1]), reach)

    def bump(self, xy: tuple[float, float], direction: tuple[float, float]) -> None:
        """Note that a move was blocked.

        Args:
            xy: of the robot, metres.
            direction: cosine and sine of its yaw.
        """
        a, b = kernels.cell(xy[0] + _BUMP_M * direction[0], xy[1] + _BUMP_M * direction[1])
        self.votes[a, b] = _BUMPED
        self._include(a, b, 1)

    def free(self, radius_m: float = RADIUS_M) -> NDArray[np.bool_]:
        """Cells where the robot's middle can be; what was not seen yet counts as free.

        Args:
            radius_m: of the robot.

        Returns:
            (1285, 1285) bool.
        """
        free = np.ones((SIZE, SIZE), bool)
        span = int(radius_m / FINE_M)
        a0, a1, b0, b1 = self._bounds + np.array([-span, span + 1, -span, span + 1])
        window = (slice(max(a0, 0), min(a1, SIZE)), slice(max(b0, 0), min(b1, SIZE)))
        taken = (self.votes[window] >= kernels.LEAST_VOTES).astype(np.uint8)
        free[window] = cv2.dilate(taken, _disc(radius_m)) == 0
        return free

    def _include(self, a: int, b: int, reach: int) -> None:
        """Extend the bounds by the cells within ``reach`` of one."""
        low, high = self._bounds[::2], self._bounds[1::2]
        np.minimum(low, (a - reach, b - reach), out=low)
        np.maximum(high, (a + reach, b + reach), out=high)


def _disc(radius_m: float) -> NDArray[np.uint8]:
    """Cells within a radius of the one in the middle, as 0 and 1."""
    span = int(radius_m / FINE_M)
    a, b = np.mgrid[-span : span + 1, -span : span + 1]
    return (np.hypot(a, b) * FINE_M <= radius_m).astype(np.uint8)
