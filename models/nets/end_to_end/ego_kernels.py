"""Kernels of one frame in the agent's frame of reference: which cells it shows, and what it shows of each thing.

Arithmetic is in float32 where the frame's arrays are, so that at the edges of cells a kernel decides as NumPy would.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, U8, jit

_HALF, _CELL = np.float32(0.5), np.float32(0.25)
_LOW_M, _TALL_M, _OPAQUE_M = np.float32(0.05), np.float32(1.8), np.float32(1.2)
_RADIUS2_M2 = np.float32(0.18**2)
_FARTHEST_M = np.float32(30.0)
#: Bits of the patch: a sight line ended in a cell or passed over it; floor was seen in it; an obstacle leaves no room
#: to stand there; something in it stands too high to look over.
EXPLORED, SEEN_FLOOR, BLOCKED, OPAQUE = 1, 2, 4, 8


@jit
def mark_floor(points: F32, spread: F32, stride: int, shape: Any, flags: U8, nearest: F32, cell: Any) -> None:
    """Enter every ``stride``-th point of a frame, in rows and columns, into the patch.

    Args:
        points: (3, H, W) float32 in metres ahead, to the left, and above the floor.
        spread: (H, W) float32, horizontal distance, inf without a hit.
        stride: rows and columns between two points.
        shape: cells ahead, to either side, and behind, and columns of the patch.
        flags: (n,) uint8, bits of every cell, updated.
        nearest: (n,) float32, least distance from which each cell was seen, updated.
        cell: (h, w) int64, written: cell of every point, -1 outside the patch.
    """
    ahead, aside, behind, columns = shape
    n = flags.shape[0]
    for a in range(cell.shape[0]):
        for b in range(cell.shape[1]):
            v, u = a * stride, b * stride
            x, y, z, away = points[0, v, u], points[1, v, u], points[2, v, u], spread[v, u]
            cell[a, b] = -1
            if not away < _FARTHEST_M:
                continue
            f, left = np.floor(x / _CELL + _HALF), np.floor(y / _CELL + _HALF)
            if f < -behind or f > ahead or abs(left) > aside:
                continue
            at = (int(f) + behind) * columns + int(left) + aside
            cell[a, b] = at
            nearest[at] = min(nearest[at], away)
            flags[at] |= EXPLORED
            if z < _LOW_M:
                flags[at] |= SEEN_FLOOR
            elif z < _TALL_M:
                flags[at] |= BLOCKED | (OPAQUE if z >= _OPAQUE_M else 0)
                dx, dy = x - f * _CELL, y - left * _CELL
                down, right = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
                ex, ey = _CELL - abs(dx), _CELL - abs(dy)
                for k in range(1, 4):
                    gx, gy = (ex if k & 1 else dx), (ey if k & 2 else dy)
                    near = at + (k & 1) * down * columns + (k >> 1) * right
                    beside = at % columns + (k >> 1) * right
                    if 0 <= near < n and 0 <= beside < columns and gx * gx + gy * gy < _RADIUS2_M2:
                        flags[near] |= BLOCKED


@jit
def measure(image: Any, points: F32, spread: F32, count: Any, sums: F64, nearest: F32, box: Any) -> None:
    """Count and sum up the pixels of each thing.

    Args:
        image: (H, W) int16, thing of every pixel, -1 for none.
        points: (3, H, W) float32, as in :func:`mark_floor`.
        spread: (H, W) float32, as in :func:`mark_floor`; pixels without a hit do not count.
        count: (n,) int64, updated: pixels of each thing.
        sums: (3, n) float64, updated: sums of their points.
        nearest: (n,) float32, updated: least horizontal distance.
        box: (n, 4) int64, updated: least and greatest column, least and greatest row.
    """
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            k = image[v, u]
            if k < 0 or not spread[v, u] < np.inf:
                continue
            count[k] += 1
            for axis in range(3):
                sums[axis, k] += points[axis, v, u]
            nearest[k] = min(nearest[k], spread[v, u])
            box[k, 0], box[k, 1] = min(box[k, 0], u), max(box[k, 1], u)
            box[k, 2], box[k, 3] = min(box[k, 2], v), max(box[k, 3], v)


@jit
def mark_pairs(image: Any, stride: int, cell: Any, columns: int, out: Any) -> None:
    """Mark which things show in which cells.

    Args:
        image: (H, W) int16, thing of every pixel, -1 for none.
        stride: rows and columns between two points.
        cell: (h, w) int64, cell of every ``stride``-th pixel, -1 outside the patch.
        columns: cells of the patch.
        out: (n * columns,) bool, written: by thing and cell.
    """
    for a in range(cell.shape[0]):
        for b in range(cell.shape[1]):
            k = image[a * stride, b * stride]
            if k >= 0 and cell[a, b] >= 0:
                out[k * columns + cell[a, b]] = True
