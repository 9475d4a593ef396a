"""Kernels of space: how much floor that is unexplored, or was seen only from far away, a view would show."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import sector
from ucon.core.jit import F64, I32, U8, jit, merged
from ucon.perception.mapping.map_kernels import CELL_M

#: Rays end at cells with something this high, metres.
OPAQUE_M = 1.2
#: Rays of a full turn, and cells of a ray.
RAYS = 64
MOST_CELLS = 32
#: Weight of each further unexplored cell of a ray, relative to the one before: exp(-CELL_M / 2 m). It is a literal,
#: since the last bit of NumPy's exp depends on the processor, and that bit would decide between equal views.
DEEPER = 0.8824969025845953
#: Unexplored cells of a ray that count, 3 m. An integer count, since a limit on the remaining weight would depend on
#: its last bit.
DEEP_CELLS = 12
#: Bits of a cell's state, as rays read it.
UNEXPLORED, TALL, FAR = 1, 2, 4


def _rays() -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """The cells of each ray, relative to its node, and the floor area that each cell stands for.

    A cell that a ray enters twice has no area the second time. Ray r looks along (r + 0.5) / RAYS of a turn.

    Returns:
        Offsets (RAYS, MOST_CELLS, 2) int32 and square metres (RAYS, MOST_CELLS) float64.
    """
    angle = 2.0 * np.pi * (np.arange(RAYS) + 0.5) / RAYS
    k = np.arange(1, MOST_CELLS + 1)
    way = np.stack([np.cos(angle), np.sin(angle)], 1)[:, None] * k[:, None]
    cell = np.floor(way + 0.5).astype(np.int32)
    area = np.tile(k * CELL_M * CELL_M * 2.0 * np.pi / RAYS, (RAYS, 1))
    area[:, 1:][(cell[:, 1:] == cell[:, :-1]).all(-1)] = 0.0
    return cell, area


RAY_CELL, RAY_AREA = _rays()


@jit
def space_gain(nodes: I32, cells: Any, reach: tuple[int, float], weight: tuple[float, float], out: F64) -> None:
    """Add the weighted area that each heading at each node would newly show.

    Args:
        nodes: (n, 2) int32.
        cells: explored, height, near, stale, interest, all (m, m). ``stale`` multiplies all area, ``interest`` the
            unexplored area.
        reach: how far unexplored space counts, cells; and from how near explored space must have been seen, metres.
        weight: of a square metre of unexplored space, and of explored space that was seen only from farther away.
        out: (n, H) float64, updated.
    """
    if not nodes.shape[0]:
        return
    state = np.zeros(cells[0].shape, np.uint8)
    _states(
        cells, reach[1], nodes[:, 0].min() - MOST_CELLS, nodes[:, 0].max() + MOST_CELLS,
        nodes[:, 1].min() - MOST_CELLS, nodes[:, 1].max() + MOST_CELLS, state,
    )  # fmt: skip
    for n in range(nodes.shape[0]):
        for ray in range(RAYS):
            heading = sector((ray + 0.5) / RAYS, out.shape[1])
            out[n, heading] += _ray(nodes[n, 0], nodes[n, 1], ray, cells, state, reach, weight, 1.0)


@jit
def fade_space(i: int, j: int, looks: tuple[int, int], cells: Any, reach: tuple[int, float], factor: float) -> None:
    """Multiply ``stale`` at the cells that a view was expected to show newly (and evidently did not show).

    Args:
        i: of the node.
        j: of the node.
        looks: heading, and number of headings.
        cells: as in :func:`space_gain`.
        reach: as in :func:`space_gain`.
        factor: multiplies ``stale``.
    """
    state = np.zeros(cells[0].shape, np.uint8)
    _states(cells, reach[1], i - MOST_CELLS, i + MOST_CELLS, j - MOST_CELLS, j + MOST_CELLS, state)
    for ray in range(RAYS):
        if sector((ray + 0.5) / RAYS, looks[1]) == looks[0]:
            _ray(i, j, ray, cells, state, reach, (1.0, 1.0), factor)


@jit
def _states(cells: Any, reach_m: float, i0: int, i1: int, j0: int, j1: int, out: U8) -> None:
    """Whether each cell of a window is unexplored, tall or seen only from far away, as bits of one array for all rays.

    Args:
        cells: as in :func:`space_gain`.
        reach_m: from how near explored space must have been seen, metres.
        i0: first row of the window.
        i1: last row.
        j0: first column.
        j1: last column.
        out: (m, m) uint8, written there: ``UNEXPLORED``, ``TALL``, ``FAR`` bits.
    """
    explored, height, near, _, _ = cells
    far_m = reach_m + 0.25
    for i in range(max(i0, 0), min(i1 + 1, out.shape[0])):
        for j in range(max(j0, 0), min(j1 + 1, out.shape[1])):
            code = (explored[i, j] == 0) * UNEXPLORED | (height[i, j] >= OPAQUE_M) * TALL | (near[i, j] > far_m) * FAR
            out[i, j] = code


@merged
def _ray(
    i0: int, j0: int, ray: int, cells: Any, state: U8, reach: tuple[int, float], weight: tuple[float, float],
    factor: float,
) -> float:  # fmt: skip
    """Weighted area of one ray, in square metres; multiplies ``stale`` of the counted cells by ``factor``."""
    stale, interest = cells[3], cells[4]
    gain, trust, deep = 0.0, 1.0, 0
    near_cells = int(reach[1] / CELL_M)
    for k in range(min(reach[0], MOST_CELLS)):
        i, j = i0 + RAY_CELL[ray, k, 0], j0 + RAY_CELL[ray, k, 1]
        if i < 1 or j < 1 or i >= state.shape[0] - 1 or j >= state.shape[1] - 1:
            break
        code = state[i, j]
        if code == 0:
            continue
        if code & UNEXPLORED and not code & TALL:
            gain += weight[0] * RAY_AREA[ray, k] * stale[i, j] * interest[i, j] * trust
            trust *= DEEPER
            deep += 1
            stale[i, j] *= factor
        elif code & FAR and k < near_cells:
            gain += weight[1] * RAY_AREA[ray, k] * stale[i, j]
            stale[i, j] *= factor
        if code & TALL or deep >= DEEP_CELLS:
            break
    return gain
