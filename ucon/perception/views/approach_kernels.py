"""Kernel of walking up to a thing: the cheapest pose from which it should be visible and within reach."""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.compass import DIRECTIONS, TAN_HALF
from ucon.core.jit import F64, I32, U8, jit, merged
from ucon.perception.mapping.map_kernels import CELL_M
from ucon.perception.views.view_kernels import sight

#: Added to a pose's cost, in actions: if something known hides the thing, if the thing would be small in view, and for
#: each time the pose failed.
UNSEEN_COST = 25
SMALL_COST = 4
FAILED_COST = 30


@jit
def best_views(
    boxes: F64, reach_m: F64, cells: Any, allowed: U8, eyes: F64, look: int, seen: F64, failed: I32, best: I32,
    cost: I32,
) -> None:  # fmt: skip
    """Find the best pose for each of m things.

    Args:
        boxes: (m, 6) float64, what was seen of the things, metres.
        reach_m: (m,) float64, horizontal distance that is near enough, metres.
        cells: steps (n, n, H) int32, actions to every node and heading; height (n, n); walls (2, n, n); half.
        allowed: (n, n) uint8, above 0 at nodes that may be stood on.
        eyes: (L, 4) float64, height in metres, cosine and sine of the pitch, look in degrees.
        look: the current look.
        seen: (m, 2) float64, pixels of the best sight so far and its distance; predicts the size from nearby.
        failed: (k, 5) int32, poses (i, j, heading, look) that failed, and how often.
        best: (m, 4) int32, written: i, j, heading, row of ``eyes``.
        cost: (m,) int32, updated; on entry, the cost of unreachable things. Only cheaper poses replace it.
    """
    for k in range(boxes.shape[0]):
        sight_of = (seen[k, 0], seen[k, 1])
        cost[k] = _best_view(boxes[k], reach_m[k], cells, allowed, eyes, look, sight_of, failed, cost[k], best[k])


@jit
def _best_view(
    box: F64, reach_m: float, cells: Any, allowed: U8, eyes: F64, look: int, seen: tuple[float, float], failed: I32,
    lowest: int, best: I32,
) -> int:  # fmt: skip
    """Cost of the cheapest pose for one thing, written to ``best`` (4,); ``lowest`` if none is cheaper than that."""
    steps, _, _, half = cells
    cx, cy, cz = 0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5])
    i0, i1 = int((box[0] - reach_m) / CELL_M) + half - 1, int((box[3] + reach_m) / CELL_M) + half + 2
    j0, j1 = int((box[1] - reach_m) / CELL_M) + half - 1, int((box[4] + reach_m) / CELL_M) + half + 2
    for i in range(max(i0, 0), min(i1, steps.shape[0])):
        for j in range(max(j0, 0), min(j1, steps.shape[1])):
            if allowed[i, j] == 0 or steps[i, j].min() >= lowest:
                continue
            x, y = (i - half) * CELL_M, (j - half) * CELL_M
            gap_x, gap_y = max(box[0] - x, x - box[3], 0.0), max(box[1] - y, y - box[4], 0.0)
            if np.hypot(gap_x, gap_y) > reach_m:
                continue
            lowest = _at_node(i, j, (cx, cy, cz), cells, eyes, look, seen, failed, lowest, best)
    return lowest


@jit
def _at_node(
    i: int, j: int, center: tuple[float, float, float], cells: Any, eyes: F64, look: int, seen: tuple[float, float],
    failed: I32, lowest: int, best: I32,
) -> int:  # fmt: skip
    """Try every heading and look at one node; returns the lowest cost so far."""
    steps, height, walls, half = cells
    x, y = (i - half) * CELL_M, (j - half) * CELL_M
    dx, dy = center[0] - x, center[1] - y
    judged_m, free = -1.0, False  # a sight line depends on the camera's height, not on heading and pitch
    n = steps.shape[2]
    width = 0.93 * TAN_HALF[n]
    for heading in range(n):
        if steps[i, j, heading] >= lowest:
            continue
        c, s = DIRECTIONS[n, heading]
        flat, side = c * dx + s * dy, abs(s * dx - c * dy)
        for row in range(eyes.shape[0]):
            eye_m, cp, sp, degrees = eyes[row]
            rise = center[2] - eye_m
            optical, up = cp * flat + sp * rise, cp * rise - sp * flat
            if not (optical > 0.1 and side <= width * optical and abs(up) <= width * optical):
                continue
            cost = steps[i, j, heading] + abs(int(degrees) - look) // 30
            if cost >= lowest:
                continue
            if seen[0] * (seen[1] / max(optical, 0.1)) ** 2 < 6.0:
                cost += SMALL_COST
            cost += FAILED_COST * _failures(i, j, heading, int(degrees), failed)
            if cost >= lowest:
                continue
            if eye_m != judged_m:
                judged_m, free = eye_m, sight(x, y, eye_m, center[0], center[1], center[2], height, walls, half)
            cost += 0 if free else UNSEEN_COST
            if cost < lowest:
                lowest = cost
                best[0], best[1], best[2], best[3] = i, j, heading, row
    return lowest


@merged
def _failures(i: int, j: int, heading: int, look: int, failed: I32) -> int:
    """How often a pose failed."""
    count = 0
    for k in range(failed.shape[0]):
        if failed[k, 0] == i and failed[k, 1] == j and failed[k, 2] == heading and failed[k, 3] == look:
            count = failed[k, 4]
    return count
