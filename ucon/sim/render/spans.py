"""Scan-conversion of one convex polygon into the visibility buffer.

Most faces of a home cover a row or two, a few pixels wide. So nothing here loops over single rows or pixels or branches
on an edge: rows and pixels are processed in fixed, masked blocks, which compile to vector instructions. Blocks of
pixels begin at multiples of their length, so that two faces that meet in a block load what the other one stored.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, I32, inlined

BLOCK_PX = np.uint64(16)
"""Pixels of a row are processed in blocks of this many."""
BLOCK_ROWS = np.uint64(32)
"""Rows are processed in blocks of this many; with fewer, the compiler unrolls the loops and does not vectorise them."""

_FROM = ~np.uint64(15)
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_RAMP = np.arange(32, dtype=np.float32)


@inlined
def fill(f: int, m: int, plane: Any, rows: Any, window: Any, polygon: F32, sides: F32, spans: I32, target: Any) -> None:
    """Draw the rows y0 to y1 of a convex polygon with the depth plane ``a x + b y + c``.

    Args:
        f: number of the face.
        m: number of corners.
        plane: a, b, c.
        rows: y0 and y1.
        window: rectangle of the image to draw in.
        polygon: (2, n) float32, the corners; counter-clockwise, so edges that go down the image bound it on the left.
        sides: (2, 32) float32, working memory.
        spans: (2, 32) int32, working memory.
        target: the visibility buffer.
    """
    a, b, c = plane
    y0, y1 = rows
    depths, faces, width = target
    face = np.int32(f)
    for top in range(np.uint64(y0), np.uint64(y1), BLOCK_ROWS):
        _cross(m, top, polygon, sides)
        _round(window, sides, spans)
        for r in range(min(BLOCK_ROWS, np.uint64(y1) - top)):
            x0, x1 = spans[0, r], spans[1, r]
            if x0 >= x1:
                continue
            y = top + np.uint64(r)
            row_z = c + b * np.float32(np.int32(y))
            left, right = np.float32(x0), np.float32(x1)
            for start in range(np.uint64(x0) & _FROM, np.uint64(x1), BLOCK_PX):
                i = y * np.uint64(width) + start
                base = np.float32(np.int32(start))
                for k in range(BLOCK_PX):
                    j = i + np.uint64(k)
                    x = base + _RAMP[k]
                    z = row_z + a * x
                    old, other = depths[j], faces[j]
                    nearer = (x >= left) & (x < right) & ((z > old) | ((z == old) & (face < other)))
                    depths[j] = z if nearer else old
                    faces[j] = face if nearer else other


@inlined
def _cross(m: int, top: int, polygon: F32, sides: F32) -> None:
    """Write to ``sides`` (2, 32) where the left and right edges cross the centres of the rows from ``top`` on.

    A row belongs to an edge if floor(upper end + 1/2) <= row < floor(lower end + 1/2). This is the same as
    upper end + 1/2 < row + 1 <= lower end + 1/2. A level edge has no rows, so its slope does not matter.
    """
    base = np.float32(np.int32(top))
    for e in range(np.uint64(m)):
        n = e + np.uint64(1) if e + np.uint64(1) < np.uint64(m) else np.uint64(0)
        down = polygon[1, e] < polygon[1, n]
        upper, lower = (e, n) if down else (n, e)
        side = np.uint64(0) if down else np.uint64(1)
        x_top, y_top = polygon[0, upper], polygon[1, upper]
        x_low, y_low = polygon[0, lower], polygon[1, lower]
        slope = (x_low - x_top) / (y_low - y_top)
        begin, end = max(y_top, -_HALF) + _HALF, max(y_low, -_HALF) + _HALF
        for k in range(BLOCK_ROWS):
            y = base + _RAMP[k]
            old = sides[side, k]
            x = x_top + (y + _HALF - y_top) * slope
            here = (y + _ONE > begin) & (y + _ONE <= end)
            sides[side, k] = x if here else old


@inlined
def _round(window: Any, sides: F32, spans: I32) -> None:
    """First pixels and ends of the spans: pixels whose centres are between the sides, clipped to the window."""
    least, most = np.float32(window[0]), np.float32(window[2])
    for k in range(BLOCK_ROWS):
        spans[0, k] = np.int32(max(max(sides[0, k], -_HALF) + _HALF, least))
        spans[1, k] = np.int32(min(max(sides[1, k], -_HALF), most) + _HALF)
