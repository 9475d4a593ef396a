"""Kernel of directions: the nodes that are in view from a node and heading."""

from __future__ import annotations

from typing import Any

from ucon.core.jit import F64, I32, jit
from ucon.perception.mapping.map_kernels import CELL_M
from ucon.perception.views.view_kernels import sight

#: A node counts as in view if the point at this height above it is, metres.
ABOVE_FLOOR_M = 0.6
_DI, _DJ = (1, 0, -1, 0), (0, 1, 0, -1)


@jit
def nodes_ahead(
    view: tuple[int, int, int], reach: tuple[float, float], eye_m: float, cells: Any, unreached: int, out: I32,
    distance: F64,
) -> int:  # fmt: skip
    """Find the explored, reachable nodes in view within 45 degrees of a heading.

    Args:
        view: node i, j and heading.
        reach: least and greatest distance, metres.
        eye_m: height of the camera, metres.
        cells: steps (n, n, 4) int32, explored (n, n), height (n, n), walls (2, n, n), half.
        unreached: ``steps`` from this value on means unreachable.
        out: (m, 2) int32, written: nodes.
        distance: (m,) float64, written: metres.

    Returns:
        How many rows are written, at most m.
    """
    steps, explored, height, walls, half = cells
    i0, j0, heading = view
    c, s = _DI[heading], _DJ[heading]
    x, y = (i0 - half) * CELL_M, (j0 - half) * CELL_M
    span, count = int(reach[1] / CELL_M), 0
    for a in range(1, span + 1):
        for b in range(-a, a + 1):
            i, j = i0 + c * a - s * b, j0 + s * a + c * b
            if not (0 <= i < explored.shape[0] and 0 <= j < explored.shape[1]) or explored[i, j] == 0:
                continue
            away_m = CELL_M * (a * a + b * b) ** 0.5
            if not reach[0] <= away_m <= reach[1]:
                continue
            if min(steps[i, j, 0], steps[i, j, 1], steps[i, j, 2], steps[i, j, 3]) >= unreached:
                continue
            to_x, to_y = (i - half) * CELL_M, (j - half) * CELL_M
            if count < out.shape[0] and sight(x, y, eye_m, to_x, to_y, ABOVE_FLOOR_M, height, walls, half):
                out[count, 0], out[count, 1], distance[count] = i, j, away_m
                count += 1
    return count
