"""Kernels of frontiers on the 0.25 m map: nodes at the edge of explored space, and a pose for each group of them."""

from __future__ import annotations

import numpy as np

from ucon.core.compass import DIRECTIONS
from ucon.core.jit import F32, I32, U8, jit
from ucon.perception.views.space_kernels import OPAQUE_M

_DI, _DJ = (1, 0, -1, 0), (0, 1, 0, -1)


@jit
def edges(
    window: tuple[int, int, int, int], explored: U8, height: F32, steps: I32, unreached: int, out: U8
) -> None:  # fmt: skip
    """Mark the frontier nodes in a window: explored, reachable, and next to an unexplored cell.

    An unexplored cell that is known to be too high to see across does not count.

    Args:
        window: cells (i0, i1, j0, j1), ends excluded.
        explored: (n, n) uint8.
        height: (n, n) float32, metres.
        steps: (n, n, H) int32, actions to every node and heading.
        unreached: ``steps`` from this value on means unreachable.
        out: (i1 - i0, j1 - j0) uint8, written: 1 at frontier nodes.
    """
    i0, i1, j0, j1 = window
    for i in range(i0, i1):
        for j in range(j0, j1):
            if explored[i, j] == 0:
                continue
            if steps[i, j].min() >= unreached:
                continue
            for h in range(4):
                a, b = i + _DI[h], j + _DJ[h]
                if i0 <= a < i1 and j0 <= b < j1 and explored[a, b] == 0 and height[a, b] < OPAQUE_M:
                    out[i - i0, j - j0] = 1


@jit
def groups(label: I32, corner: tuple[int, int], explored: U8, steps: I32, out: I32) -> None:
    """A pose for every group of frontier nodes: the node nearest to the group's centre, facing unexplored space.

    The heading is the one in which most nodes of the group have an unexplored neighbour; of equal ones, the cheapest.

    Args:
        label: (a, b) int32, group of every node of a window, from 1; 0 for none.
        corner: cell (i0, j0) of the window's first row and column.
        explored: (n, n) uint8.
        steps: (n, n, H) int32, actions to every node and heading.
        out: (groups, 4) int32, written; zeros on entry: node i, j, heading, nodes of the group.
    """
    count = out.shape[0]
    middle, votes, nearest = np.zeros((count, 2)), np.zeros((count, 4), np.int32), np.full(count, np.inf)
    for i in range(label.shape[0]):
        for j in range(label.shape[1]):
            k = label[i, j] - 1
            if k >= 0:
                middle[k, 0] += i + corner[0]
                middle[k, 1] += j + corner[1]
                out[k, 3] += 1
                _vote(i + corner[0], j + corner[1], explored, votes[k])
    for k in range(count):
        middle[k, 0], middle[k, 1] = middle[k, 0] / out[k, 3], middle[k, 1] / out[k, 3]
    for i in range(label.shape[0]):
        for j in range(label.shape[1]):
            k = label[i, j] - 1
            if k < 0:
                continue
            away = abs(i + corner[0] - middle[k, 0]) + abs(j + corner[1] - middle[k, 1])
            if away < nearest[k]:
                nearest[k], out[k, 0], out[k, 1] = away, i + corner[0], j + corner[1]
    for k in range(count):
        out[k, 2] = _heading(votes[k], steps[out[k, 0], out[k, 1]])


@jit
def _vote(i: int, j: int, explored: U8, votes: I32) -> None:
    """Add to ``votes`` (4,) for each heading whether the neighbour there is unexplored.

    At the map's border the node itself stands for the neighbour.
    """
    for h in range(4):
        a = min(max(i + _DI[h], 0), explored.shape[0] - 1)
        b = min(max(j + _DJ[h], 0), explored.shape[1] - 1)
        votes[h] += explored[a, b] == 0


@jit
def _heading(votes: I32, steps: I32) -> int:
    """The heading with most votes (4,); of equal ones the one with the fewest steps (H,), then the first.

    Votes are for the four neighbours; with another number of headings, the sum of their directions decides.
    """
    n, best = steps.shape[0], 0
    if n == 4:
        for h in range(1, 4):
            if votes[h] > votes[best] or (votes[h] == votes[best] and steps[h] < steps[best]):
                best = h
        return best
    dx, dy, most = votes[0] - votes[2], votes[1] - votes[3], -1e9
    for h in range(n):
        along = DIRECTIONS[n, h, 0] * dx + DIRECTIONS[n, h, 1] * dy - 1e-3 * min(steps[h], 1000)
        if along > most:
            best, most = h, along
    return best
