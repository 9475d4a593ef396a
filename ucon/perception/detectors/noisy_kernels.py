"""Kernels of the noisy detector: pixel boxes of the instances of a frame, and the spots of space that it shows.

The camera is that of :mod:`ucon.perception.mapping.map_kernels`.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, jit
from ucon.perception.mapping.map_kernels import FAR_M

#: False positives are drawn for cubes of this side, in metres.
SPOT_M = 0.5


@jit
def outline(depth: F32, instance: I16, camera: F64, box: I32, middle: F64, count: I32) -> None:
    """Pixel box, mean point and pixel count of every instance.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        instance: (H, W) int16, -1 where there is none.
        camera: (8,) float64.
        box: (n, 4) int32, written: left, top, right, bottom; right and bottom exclusive.
        middle: (n, 3) float64, written: mean of the visible points, metres in the start frame.
        count: (n,) int32, written: visible pixels.
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    box[:, 0], box[:, 1], box[:, 2:] = columns, rows, 0
    middle[:] = 0.0
    count[:] = 0
    for v in range(rows):
        up = (0.5 * rows - v - 0.5) / focal_px
        for u in range(columns):
            k, d = instance[v, u], depth[v, u]
            if k < 0 or not 0.0 < d < FAR_M:
                continue
            f, right = d * (cp - sp * up), d * ((u + 0.5 - 0.5 * columns) / focal_px)
            box[k, 0], box[k, 2] = min(box[k, 0], u), max(box[k, 2], u + 1)
            box[k, 1], box[k, 3] = min(box[k, 1], v), max(box[k, 3], v + 1)
            middle[k, 0] += x + c * f + s * right
            middle[k, 1] += y + s * f - c * right
            middle[k, 2] += cam_z + d * (sp + cp * up)
            count[k] += 1
    for k in range(len(count)):
        if count[k]:
            middle[k] /= count[k]


@jit
def spots(depth: F32, camera: F64, grid: int, spot: I32, pixel: I32) -> int:
    """The 0.5 m cubes that the pixels of a grid x grid raster of the frame show.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        grid: raster pixels across and down.
        spot: (grid * grid, 4) int32, written: cube x, y, z, and from which of eight sides it is seen.
        pixel: (grid * grid, 2) int32, written: column u and row v.

    Returns:
        How many raster pixels show a surface; only so many rows are written.
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    n = 0
    for a in range(grid):
        v = int((a + 0.5) * rows / grid)
        up = (0.5 * rows - v - 0.5) / focal_px
        for b in range(grid):
            u = int((b + 0.5) * columns / grid)
            d = depth[v, u]
            if not 0.0 < d < FAR_M:
                continue
            f, right = d * (cp - sp * up), d * ((u + 0.5 - 0.5 * columns) / focal_px)
            dx, dy = c * f + s * right, s * f - c * right
            spot[n, 0] = int(np.floor((x + dx) / SPOT_M))
            spot[n, 1] = int(np.floor((y + dy) / SPOT_M))
            spot[n, 2] = int(np.floor((cam_z + d * (sp + cp * up)) / SPOT_M))
            spot[n, 3] = int(np.floor(np.arctan2(dy, dx) / (np.pi / 4))) % 8
            pixel[n, 0], pixel[n, 1] = u, v
            n += 1
    return n
