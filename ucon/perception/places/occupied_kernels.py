"""Kernel that counts the sight lines of a depth image that end in the boxes of places."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I32, jit
from ucon.perception.mapping.map_kernels import FAR_M

#: Boxes with a corner nearer than this are not checked, metres of optical depth.
_LEAST_M = 0.15


@jit
def fill(depth: F32, camera: F64, boxes: F64, filled: I32, passed: I32) -> None:
    """Count the sight lines of one frame that end in boxes, and those that pass through them.

    Sight lines that end before a box do not count: something hides the box.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        boxes: (n, 6) float64, x0 y0 z0 x1 y1 z1, metres.
        filled: (n,) int32, written.
        passed: (n,) int32, written.
    """
    rows, columns = depth.shape
    at, span = np.empty(3), np.empty(4, np.int32)
    at[0], at[1], at[2] = camera[0], camera[1], camera[2]
    for n in range(boxes.shape[0]):
        filled[n], passed[n] = 0, 0
        if not _span(boxes[n], camera, rows, columns, span):
            continue
        for v in range(span[1], span[3]):
            for u in range(span[0], span[2]):
                d = depth[v, u]
                if not 0.0 < d < FAR_M:
                    continue
                first, last = _within(boxes[n], at, u, v, rows, columns, camera)
                if first < last and d >= first:
                    if d <= last:
                        filled[n] += 1
                    else:
                        passed[n] += 1


@jit
def _span(box: F64, camera: F64, rows: int, columns: int, span: I32) -> bool:
    """Write the pixels u0 v0 u1 v1 that may show a box; False where none does."""
    x, y, z, c, s, cp, sp, focal_px = camera
    u0, v0, u1, v1 = np.inf, np.inf, -np.inf, -np.inf
    for corner in range(8):
        dx, dy = box[3 * (corner & 1)] - x, box[1 + 3 * ((corner >> 1) & 1)] - y
        dz = box[2 + 3 * ((corner >> 2) & 1)] - z
        ahead, right = c * dx + s * dy, s * dx - c * dy
        optical, up = cp * ahead + sp * dz, cp * dz - sp * ahead
        if optical < _LEAST_M:
            return False
        u, v = 0.5 * columns + focal_px * right / optical, 0.5 * rows - focal_px * up / optical
        u0, v0, u1, v1 = min(u0, u), min(v0, v), max(u1, u), max(v1, v)
    span[0], span[1] = max(int(np.floor(u0)), 0) if u0 < columns else columns, max(int(np.floor(v0)), 0)
    span[2], span[3] = min(int(np.ceil(u1)), columns), min(int(np.ceil(v1)), rows)
    return span[0] < span[2] and span[1] < span[3]


@jit
def _within(box: F64, at: F64, u: int, v: int, rows: int, columns: int, camera: F64) -> tuple[float, float]:
    """Optical depths, metres, at which the sight line of a pixel enters and leaves a box; equal where it misses it."""
    c, s, cp, sp, focal_px = camera[3], camera[4], camera[5], camera[6], camera[7]
    up, right = (0.5 * rows - v - 0.5) / focal_px, (u + 0.5 - 0.5 * columns) / focal_px
    ahead = cp - sp * up
    way = (c * ahead + s * right, s * ahead - c * right, sp + cp * up)
    first, last = 0.0, np.inf
    for axis in range(3):
        if abs(way[axis]) < 1e-9:
            if not box[axis] <= at[axis] <= box[3 + axis]:
                return 0.0, 0.0
            continue
        a, b = (box[axis] - at[axis]) / way[axis], (box[3 + axis] - at[axis]) / way[axis]
        first, last = max(first, min(a, b)), min(last, max(a, b))
    return (first, last) if first < last else (0.0, 0.0)
