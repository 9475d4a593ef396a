"""Kernel of directions: the nodes that are in view from a node and heading."""

from __future__ import annotations

from typing import Any

from ucon.core.compass import DIRECTIONS, TAN_HALF
from ucon.core.jit import F64, I32, jit
from ucon.perception.mapping.map_kernels import CELL_M
from ucon.perception.views.view_kernels import sight

#: A node counts as in view if the point at this height above it is, metres.
ABOVE_FLOOR_M = 0.6


@jit
def nodes_ahead(
    view: tuple[int, int, int], reach: tuple[float, float], eye_m: float, cells: Any, unreached: int, out: I32,
    distance: F64,
) -> int:  # fmt: skip
    """Find the explored, reachable nodes in the view of a heading.

    Args:
        view: node i, j and heading.
        reach: least and greatest distance, metres.
        eye_m: height of the camera, metres.
        cells: steps (n, n, H) int32, explored (n, n), height (n, n), walls (2, n, n), half.
        unreached: ``steps`` from this value on means unreachable.
        out: (m, 2) int32, written: nodes.
        distance: (m,) float64, written: metres.

    Returns:
        How many rows are written, at most m.
    """
    i0, j0, heading = view
    n, span, count = cells[0].shape[2], int(reach[1] / CELL_M), 0
    if n == 4:  # row by row of the quadrant ahead
        c, s = int(DIRECTIONS[4, heading, 0]), int(DIRECTIONS[4, heading, 1])
        for a in range(1, span + 1):
            for b in range(-a, a + 1):
                to = i0 + c * a - s * b, j0 + s * a + c * b
                count += _add((i0, j0), to, reach, eye_m, cells, unreached, out, distance, count)
        return count
    for a in range(-span, span + 1):
        for b in range(-span, span + 1):
            ahead = DIRECTIONS[n, heading, 0] * a + DIRECTIONS[n, heading, 1] * b
            aside = abs(DIRECTIONS[n, heading, 1] * a - DIRECTIONS[n, heading, 0] * b)
            if ahead > 0.0 and aside <= TAN_HALF[n] * ahead:
                count += _add((i0, j0), (i0 + a, j0 + b), reach, eye_m, cells, unreached, out, distance, count)
    return count


@jit
def _add(
    here: tuple[int, int], to: tuple[int, int], reach: tuple[float, float], eye_m: float, cells: Any, unreached: int,
    out: I32, distance: F64, count: int,
) -> int:  # fmt: skip
    """Write a node to row ``count`` if it is explored, reachable and in sight; returns how many rows were written."""
    steps, explored, height, walls, half = cells
    i, j = to
    if not (0 <= i < explored.shape[0] and 0 <= j < explored.shape[1]) or explored[i, j] == 0:
        return 0
    a, b = i - here[0], j - here[1]
    away_m = CELL_M * (a * a + b * b) ** 0.5
    if not reach[0] <= away_m <= reach[1] or steps[i, j].min() >= unreached or count >= out.shape[0]:
        return 0
    x, y, to_x, to_y = (here[0] - half) * CELL_M, (here[1] - half) * CELL_M, (i - half) * CELL_M, (j - half) * CELL_M
    if not sight(x, y, eye_m, to_x, to_y, ABOVE_FLOOR_M, height, walls, half):
        return 0
    out[count, 0], out[count, 1], distance[count] = i, j, away_m
    return 1
