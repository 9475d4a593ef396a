"""Kernel of a robot's obstacle map: votes of a frame's points for and against an obstacle in each cell of 5 cm."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, U8, jit
from ucon.perception.mapping.fine_kernels import FINE_M, PER_CELL
from ucon.perception.mapping.map_kernels import RADIUS_M

#: Cells of a side, as many as the 0.25 m map covers, and the number of the cell of the start.
SIZE = 257 * PER_CELL
HALF = 128 * PER_CELL + PER_CELL // 2
#: Points up to the first height are floor: a robot on legs steps over what is lower. Points from there to the second,
#: the top of its camera, are in its way. Metres.
LOW_M, HIGH_M = 0.08, 1.0
#: Points at more than this depth are too uncertain, metres.
SURE_M = 3.5
#: A cell with at least LEAST_VOTES is an obstacle; an obstacle point adds FOR, a floor point takes AGAINST, and a cell
#: has at most MOST_VOTES.
LEAST_VOTES, MOST_VOTES, FOR, AGAINST = 4, 24, 2, 1
_BUMPED = 255


@jit
def cell(x: float, y: float) -> tuple[int, int]:
    """The cell (a, b) that holds a point in metres, kept within the map."""
    a, b = int(np.floor(x / FINE_M + 0.5)) + HALF, int(np.floor(y / FINE_M + 0.5)) + HALF
    return min(max(a, 0), SIZE - 1), min(max(b, 0), SIZE - 1)


@jit
def vote(depth: F32, camera: F64, votes: U8) -> None:
    """Update the votes of cells by the points of a frame.

    Points within the robot's own radius are left out: it stands there.

    Args:
        depth: (H, W) float32, metres along the optical axis, 0 where there is no reading.
        camera: (8,) float64.
        votes: (n, n) uint8, updated.
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    for v in range(rows):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = cp - sp * up, sp + cp * up
        for u in range(columns):
            d = depth[v, u]
            if not 0.0 < d <= SURE_M:
                continue
            z = cam_z + d * rise
            if z >= HIGH_M:
                continue
            f, right = d * ahead, d * (u + 0.5 - 0.5 * columns) / focal_px
            dx, dy = c * f + s * right, s * f - c * right
            if dx * dx + dy * dy < RADIUS_M * RADIUS_M:
                continue
            a, b = cell(x + dx, y + dy)
            old = votes[a, b]
            if old == _BUMPED:
                continue
            if z >= LOW_M:
                votes[a, b] = min(old + FOR, MOST_VOTES)
            elif old >= AGAINST:
                votes[a, b] = old - AGAINST
