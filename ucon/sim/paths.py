"""Shortest paths on the navigation grid: breadth-first, 4-connected, one move is 0.25 m."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import EpisodeError
from ucon.core.jit import jit
from ucon.scenes.spec import GRID_M

UNREACHABLE = -1


def distances(
    free: NDArray[np.bool_],
    sources: NDArray[np.integer] | list[tuple[int, int]],
    start_costs: NDArray[np.integer] | None = None,
) -> NDArray[np.int32]:
    """Moves from the nearest source to every node.

    Args:
        free: (nx, ny) bool, nodes that may be entered.
        sources: (n, 2) nodes; those that are not free or outside are ignored.
        start_costs: (n,) moves already spent at each source, at least 0; default 0.

    Returns:
        (nx, ny) int32; -1 where there is no path.
    """
    cells = np.asarray(sources, np.int64).reshape(-1, 2)
    costs = np.zeros(len(cells), np.int64) if start_costs is None else np.asarray(start_costs, np.int64)
    order = np.argsort(costs, kind="stable")
    return _flood(np.ascontiguousarray(free), cells[order], costs[order])


def metres(steps: int | np.integer) -> float:
    """Length of a path of ``steps`` moves, in metres."""
    return float(steps) * GRID_M


def path(dist: NDArray[np.int32], start: tuple[int, int]) -> list[tuple[int, int]]:
    """A shortest path to a source.

    Args:
        dist: (nx, ny) of :func:`distances`.
        start: node to start from.

    Returns:
        Nodes from ``start`` to the source, both included; ties go to +x, +y, -x, -y in this order.

    Raises:
        EpisodeError: no source can be reached from ``start``.
    """
    if not (0 <= start[0] < dist.shape[0] and 0 <= start[1] < dist.shape[1]) or dist[start] == UNREACHABLE:
        raise EpisodeError(f"node {start} has no path to any goal; start on a free node of the goal's component")
    return [(int(i), int(j)) for i, j in _descend(dist, start[0], start[1])]


@jit
def _flood(free: NDArray[np.bool_], cells: NDArray[np.int64], costs: NDArray[np.int64]) -> NDArray[np.int32]:
    nx, ny = free.shape
    dist = np.full((nx, ny), -1, np.int32)
    queue = np.empty((nx * ny, 2), np.int32)
    head, tail, source, n = 0, 0, 0, len(cells)
    while head < tail or source < n:
        # Sources are sorted by cost. A source enters after every node nearer than its cost has entered, so the
        # queue stays in order of distance and no node is entered twice.
        if source < n and (head == tail or costs[source] <= dist[queue[head, 0], queue[head, 1]]):
            i, j, d = cells[source, 0], cells[source, 1], costs[source]
            source += 1
            if i < 0 or j < 0 or i >= nx or j >= ny or not free[i, j] or (dist[i, j] >= 0 and dist[i, j] <= d):
                continue
        else:
            i, j = queue[head, 0], queue[head, 1]
            d = dist[i, j]
            head += 1
        dist[i, j] = d
        for k in range(4):
            a = i + (k == 0) - (k == 2)
            b = j + (k == 1) - (k == 3)
            if 0 <= a < nx and 0 <= b < ny and free[a, b] and dist[a, b] < 0:
                dist[a, b] = d + 1
                queue[tail, 0], queue[tail, 1] = a, b
                tail += 1
    return dist


@jit
def _descend(dist: NDArray[np.int32], i: int, j: int) -> list[tuple[int, int]]:
    nx, ny = dist.shape
    cells = [(i, j)]
    moved = True
    while moved:
        moved = False
        for k in range(4):
            a = i + (k == 0) - (k == 2)
            b = j + (k == 1) - (k == 3)
            if 0 <= a < nx and 0 <= b < ny and dist[a, b] >= 0 and dist[a, b] == dist[i, j] - 1:
                i, j = a, b
                cells.append((i, j))
                moved = True
                break
    return cells


@jit
def components(free: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Connected components of the free nodes.

    Returns:
        (nx, ny) int32, component number from 0; -1 where not free.
    """
    nx, ny = free.shape
    label = np.full((nx, ny), -1, np.int32)
    stack = np.empty((nx * ny, 2), np.int32)
    count = 0
    for si in range(nx):
        for sj in range(ny):
            if not free[si, sj] or label[si, sj] >= 0:
                continue
            label[si, sj] = count
            stack[0, 0], stack[0, 1] = si, sj
            top = 1
            while top > 0:
                top -= 1
                i, j = stack[top, 0], stack[top, 1]
                for k in range(4):
                    a = i + (k == 0) - (k == 2)
                    b = j + (k == 1) - (k == 3)
                    if 0 <= a < nx and 0 <= b < ny and free[a, b] and label[a, b] < 0:
                        label[a, b] = count
                        stack[top, 0], stack[top, 1] = a, b
                        top += 1
            count += 1
    return label
