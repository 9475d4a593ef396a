"""Flood fill over a small boolean grid, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True, error_model="numpy")
def flood(free: NDArray[np.bool_], i: int, j: int) -> NDArray[np.bool_]:
    """Cells of ``free`` (nx, ny) joined to (i, j) over 4-neighbours, (nx, ny) bool."""
    nx, ny = free.shape
    seen = np.zeros((nx, ny), np.bool_)
    if not free[i, j]:
        return seen
    stack = np.empty((nx * ny, 2), np.int32)
    stack[0, 0], stack[0, 1] = i, j
    seen[i, j] = True
    top = 1
    while top:
        top -= 1
        a, b = stack[top, 0], stack[top, 1]
        for k in range(4):
            p = a + (k == 0) - (k == 1)
            q = b + (k == 2) - (k == 3)
            if 0 <= p < nx and 0 <= q < ny and free[p, q] and not seen[p, q]:
                seen[p, q] = True
                stack[top, 0], stack[top, 1] = p, q
                top += 1
    return seen


def count_reached(free: NDArray[np.bool_], reached: NDArray[np.bool_]) -> int:
    """Number of free cells that were not reached."""
    return int((free & ~reached).sum())
