"""Kernels that count what every pose around an agent would show, by rays over the map memory."""

from __future__ import annotations

from typing import Any

import numpy as np

from models.nets.end_to_end.ego_kernels import EXPLORED, OPAQUE
from models.nets.end_to_end.memory_kernels import TARGET
from models.nets.end_to_end.way_kernels import FAR
from ucon.core.jit import F32, I16, I32, U8, jit, merged
from ucon.perception.views.space_kernels import RAY_AREA, RAY_CELL, RAYS

#: What is counted of every pose, see :data:`models.nets.end_to_end.floor_memory.OUTLOOK`.
N_OUTLOOK = 10
ON, BESIDE, INSIDE, USED, CLOSED, SPACE, THIN, TARGETED, BEEN, AROUND = range(N_OUTLOOK)
#: Cells of a ray (5.5 m).
_MOST = 22
#: Weight of each further unexplored cell of a ray relative to the one before, and how many count.
_DEEPER, _DEEP_CELLS = np.float32(0.8825), 12
#: Containers can be opened from so many cells away, and the target is taken from there.
_REACH_CELLS = 4
_CELL_M2 = 0.0625
#: Square metres that each cell of a ray stands for.
_AREA = RAY_AREA.astype(np.float32)


@jit
def look_out(
    flags: U8, look: U8, who: I16, visits: U8, share: F32, extent: I32, pose: I32, sight: I32, enough: U8, steps: U8,
    cell: U8, patience: int, out: F32,
) -> None:  # fmt: skip
    """Count what each pose that can be reached would show.

    Args:
        flags: (B, S, S).
        look: (B, S, S).
        who: (B, 2, S, S).
        visits: (B, 4, S, S).
        share: (B, N, 4) belief of every track in each of its cells: on it, beside it, in it, behind its closed doors.
        extent: (B, N) cells of every track.
        pose: (B, 4).
        sight: (B,) how many cells away the target would be seen.
        enough: (B,) what was seen as closely as this would have shown it.
        steps: (B, 4, C, C) of :func:`find_ways`.
        cell: (B, C, C) of :func:`find_ways`.
        patience: a pose that the agent was in for so many steps shows nothing more.
        out: (B, N_OUTLOOK, 4, C, C) written, 0 where there is no way.
    """
    size, coarse = flags.shape[1], cell.shape[1]
    half, reach = size // 2, coarse - 1
    counted, asked = np.zeros((size, size), np.int32), np.zeros(extent.shape[1], np.int32)
    found = np.zeros((N_OUTLOOK, 4), np.float32)
    mark = 0
    out[:] = 0.0
    for b in range(flags.shape[0]):
        maps = (flags[b], look[b], who[b], share[b], extent[b])
        for a in range(coarse):
            for c in range(coarse):
                if steps[b, 0, a, c] == FAR:
                    continue
                i = pose[b, 0] + half - reach + 2 * a + (cell[b, a, c] >> 1)
                j = pose[b, 1] + half - reach + 2 * c + (cell[b, a, c] & 1)
                if not (0 < i < size - 1 and 0 < j < size - 1):
                    continue
                beside = flags[b, i - 1, j] | flags[b, i + 1, j] | flags[b, i, j - 1] | flags[b, i, j + 1]
                if not (flags[b, i, j] | beside) & EXPLORED:
                    continue
                found[:] = 0.0
                _look_from(i, j, maps, sight[b], enough[b], counted, asked, mark, found)
                mark += 4
                for h in range(4):
                    if visits[b, h, i, j] >= patience:
                        found[:, h] = 0.0
                _been(i, j, visits[b], found)
                for k in range(N_OUTLOOK):
                    for h in range(4):
                        out[b, k, h, a, c] = found[k, h]


@jit
def _look_from(
    i0: int, j0: int, maps: Any, sight: int, enough: int, counted: I32, asked: I32, mark: int, out: F32
) -> None:
    """Count what a node would show in each heading; cells and containers count once a heading.

    Args:
        i0: of the node.
        j0: of the node.
        maps: flags, look, who, share and extent of one map.
        sight: how many cells away the target would be seen.
        enough: what was seen as closely as this would have shown it.
        counted: (S, S) scratch: the last (node, heading) that counted each cell.
        asked: (N,) scratch, the same of containers.
        mark: number of (node, heading) pairs before this node.
        out: (N_OUTLOOK, 4) updated.
    """
    flags, look, who, share, extent = maps
    for ray in range(RAYS):
        h = ((ray + RAYS // 8) % RAYS) // (RAYS // 4)
        trust, deep = np.float32(1.0), 0
        for k in range(_MOST):
            i, j = i0 + RAY_CELL[ray, k, 0], j0 + RAY_CELL[ray, k, 1]
            inside = 0 <= i < flags.shape[0] and 0 <= j < flags.shape[0]
            bits = flags[i, j] if inside else np.uint8(0)
            if not bits & EXPLORED:
                if not bits & OPAQUE:
                    out[SPACE, h] += _AREA[ray, k] * trust
                    trust *= _DEEPER
                    deep += 1
            elif counted[i, j] != mark + h + 1:
                counted[i, j] = mark + h + 1
                _count(i, j, k, h, look[i, j] < enough, sight, who, share, extent, asked, mark, out)
                if bits & TARGET:
                    out[TARGETED, h] = max(out[TARGETED, h], np.float32(1.0 if k < _REACH_CELLS else 2.0 / (k + 1)))
            if bits & OPAQUE or deep >= _DEEP_CELLS:
                break


@jit
def _count(
    i: int, j: int, k: int, h: int, fresh: bool, sight: int, who: I16, share: F32, extent: I32, asked: I32, mark: int,
    out: F32,
) -> None:  # fmt: skip
    """Count one cell that shows in a heading, k + 1 cells away."""
    if k < sight and fresh:
        out[THIN, h] += np.float32(_CELL_M2)
    for layer in range(2):
        track = who[layer, i, j]
        if track < 0:
            continue
        if k < sight and fresh:
            out[ON, h] += share[track, 0]
            out[BESIDE, h] += share[track, 1]
            out[INSIDE, h] += share[track, 2]
        elif k < sight:
            out[USED, h] += share[track, 0] + share[track, 1] + share[track, 2]
        if k < _REACH_CELLS and share[track, 3] > 0 and asked[track] != mark + h + 1:
            asked[track] = mark + h + 1
            out[CLOSED, h] += share[track, 3] * extent[track]


@merged
def _been(i: int, j: int, visits: U8, out: F32) -> None:
    """Write how often the agent stood near a node with each heading, and with any; in units of four steps."""
    size = visits.shape[1]
    total = 0
    for h in range(4):
        most = 0
        for a in range(max(i - 1, 0), min(i + 2, size)):
            for c in range(max(j - 1, 0), min(j + 2, size)):
                most += visits[h, a, c]
        out[BEEN, h] = np.float32(0.25 * min(most, 16))
        total += most
    for h in range(4):
        out[AROUND, h] = np.float32(0.25 * min(total, 32))
