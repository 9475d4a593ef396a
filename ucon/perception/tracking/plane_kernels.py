"""Kernels that cut a frame into plane patches: a plane's inverse depth is linear in the image."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, I32, U8, jit, merged
from ucon.perception.mapping.map_kernels import FAR_M

#: Three pixels in a row lie on one plane if their inverse depths are linear up to this share.
PLANE_TOLERANCE = np.float32(1e-3)


@jit
def planes(depth: F32, plane: I32) -> int:
    """Cut a frame into plane patches: neighbouring pixels whose inverse depth is linear, as that of a plane is.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        plane: (H, W) int32, written: number of the patch of every pixel, from 0.

    Returns:
        How many patches there are.
    """
    rows, columns = depth.shape
    left, above = np.zeros((rows, columns), np.uint8), np.zeros((rows, columns), np.uint8)
    _links(depth, left, above)
    root = np.empty(rows * columns, np.int32)
    for v in range(rows):
        run = v * columns
        for u in range(columns):  # runs of a row first: a join costs more
            if left[v, u] == 0:
                run = v * columns + u
            root[v * columns + u] = run
        for u in range(columns):
            known = u > 0 and above[v, u - 1] & left[v, u] & left[v - 1, u]  # joined by the pixels to the left
            if above[v, u] and not known:
                _join(root, (v - 1) * columns + u, v * columns + u)
    n, flat = 0, plane.reshape(rows * columns)
    for here in range(rows * columns):  # roots come before what joined them
        if root[here] == here:
            flat[here] = n
            n += 1
        else:
            flat[here] = flat[root[here]]
    return n


@jit
def _links(depth: F32, left: U8, above: U8) -> None:
    """Write 1 where a pixel lies on one plane with the pixel to its left, and with the one above it.

    It does where the inverse depth is linear across one of the two pixels.
    """
    rows, columns = depth.shape
    inverse = np.empty((rows, columns), np.float32)
    across, along = np.zeros((rows, columns), np.uint8), np.zeros((rows, columns), np.uint8)
    for v in range(rows):
        for u in range(columns):
            d = depth[v, u]
            inverse[v, u] = np.float32(1.0) / d if 0.0 < d < FAR_M else np.float32(0.0)
    for v in range(rows):
        for u in range(1, columns - 1):
            at = inverse[v, u]
            across[v, u] = abs(inverse[v, u - 1] + inverse[v, u + 1] - 2 * at) <= PLANE_TOLERANCE * at
    for v in range(1, rows - 1):
        for u in range(columns):
            at = inverse[v, u]
            along[v, u] = abs(inverse[v - 1, u] + inverse[v + 1, u] - 2 * at) <= PLANE_TOLERANCE * at
    for v in range(rows):
        for u in range(1, columns):
            left[v, u] = across[v, u - 1] | across[v, u]
    for v in range(1, rows):
        for u in range(columns):
            above[v, u] = along[v - 1, u] | along[v, u]


@merged
def _join(root: I32, a: int, b: int) -> None:
    """Join the sets of two elements; the smaller root stays."""
    while root[a] != a:
        root[a] = root[root[a]]
        a = root[a]
    while root[b] != b:
        root[b] = root[root[b]]
        b = root[b]
    if a < b:
        root[b] = a
    elif b < a:
        root[a] = b
