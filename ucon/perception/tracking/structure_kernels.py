"""Kernels that classify, by geometry, the pixels that belong to no thing.

The camera is that of :mod:`ucon.perception.mapping.map_kernels`; heights are metres above the floor.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I16, U8, jit
from ucon.perception.mapping.map_kernels import CELL_M, FAR_M, point
from ucon.perception.tracking.segment_kernels import FLOOR_M

#: Points above this height are ceiling, metres.
CEILING_M = 2.2
#: An upright plane above this height is a wall: apart from wardrobes no furniture of the catalogue is that high.
ABOVE_FURNITURE_M = 1.95
FLOORS, WALLS, CEILINGS, OBSTACLES = 0, 1, 2, 3


@jit
def structure(depth: F32, camera: F64, half: int, upright: U8, image: I16) -> None:
    """Classify the pixels that belong to no thing as floor, wall, ceiling or obstacle.

    A pixel is a wall if it lies on an upright plane along an axis, at a cell border where such a plane was seen above
    all furniture, in this frame or an earlier one. Only every second row and column is classified: the map's cells are
    made from these.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        half: cell number of the start.
        upright: (2, n, n) uint8, updated: cell borders with a plane above all furniture; axes as the map's ``walls``.
        image: (H, W) int16, track of every pixel; entries of -1 with depth are set to 0 to 3.
    """
    rows, columns = depth.shape
    for marking in (True, False):
        for v in range(0, rows, 2):
            for u in range(0, columns, 2):
                d = depth[v, u]
                if image[v, u] >= 0 or not 0.0 < d < FAR_M:
                    continue
                z = point(u, v, d, rows, columns, camera)[2]
                if marking:
                    if z > ABOVE_FURNITURE_M:
                        _border(depth, u, v, camera, half, upright, True)
                elif z < FLOOR_M:
                    image[v, u] = FLOORS
                elif z > CEILING_M:
                    image[v, u] = CEILINGS
                else:
                    image[v, u] = WALLS if _border(depth, u, v, camera, half, upright, False) else OBSTACLES


@jit
def _border(depth: F32, u: int, v: int, camera: F64, half: int, upright: U8, mark: bool) -> bool:
    """Whether a pixel lies on an upright plane at a marked cell border; with ``mark`` the border is marked first."""
    rows, columns = depth.shape
    a, b = (u + 1 if u + 1 < columns else u - 1), (v + 1 if v + 1 < rows else v - 1)
    x, y, z = point(u, v, depth[v, u], rows, columns, camera)
    x1, y1, z1 = point(a, v, depth[v, a], rows, columns, camera)
    x2, y2, z2 = point(u, b, depth[b, u], rows, columns, camera)
    x1, y1, z1, x2, y2, z2 = x1 - x, y1 - y, z1 - z, x2 - x, y2 - y, z2 - z
    nx, ny, nz = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0.0 or abs(nz) > 0.15 * length or max(abs(nx), abs(ny)) < 0.97 * length:
        return False
    axis = 0 if abs(nx) > abs(ny) else 1
    across, along = (x, y) if axis == 0 else (y, x)
    border = int(np.floor(across / CELL_M))
    if abs(across - (border + 0.5) * CELL_M) > 0.08:
        return False
    cell = int(np.floor(along / CELL_M + 0.5)) + half
    i, j = (border + half, cell) if axis == 0 else (cell, border + half)
    if not (0 <= i < upright.shape[1] and 0 <= j < upright.shape[2]):
        return False
    if mark:
        upright[axis, i, j] = 1
    return upright[axis, i, j] == 1
