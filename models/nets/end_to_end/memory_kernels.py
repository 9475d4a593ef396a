"""Kernels that write frames into the map memory, and sum up maps.

All work on B maps at once. A map is a grid of cells of 0.25 m; cell (i, j) lies i ahead and j to the left of where the
agent started. Headings are quarter turns to the left: 0 looks along i, 1 along j.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED
from ucon.core.jit import F32, I16, I32, U8, jit, merged

#: Further bits of a cell, besides those of a frame: the target was seen in it, something in it was opened, the agent
#: stood there.
TARGET, OPENED, VISITED = 16, 32, 64
_CELL_M2 = 0.0625


@merged
def _turn(heading: int, f: int, left: int) -> tuple[int, int]:
    """Offset in cells along i and j of what lies ``f`` ahead and ``left`` to the left at this heading."""
    if heading == 0:
        return f, left
    if heading == 1:
        return -left, f
    if heading == 2:
        return -f, -left
    return left, -f


@jit
def write_floor(flags: U8, look: U8, visits: U8, pose: I32, collision: Any, patch: U8, looks: U8, behind: int) -> None:
    """Write what a frame shows of the floor, and where the agent stands.

    Args:
        flags: (B, S, S), bits of every cell, updated.
        look: (B, S, S), how closely every cell was seen, updated.
        visits: (B, 4, S, S), how often the agent stood there with each heading, updated.
        pose: (B, 4) cell (i, j) from the start, heading, look up or down.
        collision: (B,) bool, the last move hit something: the cell ahead is blocked.
        patch: (B, R, C) bits of the cells ahead.
        looks: (B, R, C) how closely these were seen.
        behind: rows of the patch behind the agent.
    """
    size, rows, columns = flags.shape[1], patch.shape[1], patch.shape[2]
    half, aside = size // 2, columns // 2
    for b in range(flags.shape[0]):
        i0, j0, heading = pose[b, 0] + half, pose[b, 1] + half, pose[b, 2] & 3
        for r in range(rows):
            for c in range(columns):
                if patch[b, r, c] == 0 and looks[b, r, c] == 0:
                    continue
                di, dj = _turn(heading, r - behind, c - aside)
                i, j = i0 + di, j0 + dj
                if 0 <= i < size and 0 <= j < size:
                    flags[b, i, j] |= patch[b, r, c]
                    look[b, i, j] = max(look[b, i, j], looks[b, r, c])
        if collision[b]:
            di, dj = _turn(heading, 1, 0)
            i, j = i0 + di, j0 + dj
            if 0 <= i < size and 0 <= j < size:
                flags[b, i, j] |= BLOCKED
        i, j = min(max(i0, 0), size - 1), min(max(j0, 0), size - 1)
        flags[b, i, j] |= EXPLORED | VISITED
        visits[b, heading, i, j] = min(visits[b, heading, i, j] + 1, 255)


@jit
def write_things(
    flags: U8, who: I16, extent: I32, mass: F32, pose: I32, cells: I16, rows: I16, tracks: I16, targets: Any,
    opened: Any, columns: int, behind: int,
) -> None:  # fmt: skip
    """Write which things are in which cell; of more than two, those with the most belief.

    Args:
        flags: (B, S, S), updated.
        who: (B, 2, S, S) tracks in every cell, -1 for none, updated.
        extent: (B, N) cells of every track, updated.
        mass: (B, N, 4) belief of every track.
        pose: (B, 4).
        cells: (B, P) cell of the patch of each (thing, cell) pair, -1 for none.
        rows: (B, P) number of the thing in the frame.
        tracks: (B, K) track of each thing in the frame.
        targets: (B, K) bool, is of the target's category.
        opened: (B, N) bool, by track.
        columns: of the patch.
        behind: rows of the patch behind the agent.
    """
    size = flags.shape[1]
    half, aside = size // 2, columns // 2
    for b in range(flags.shape[0]):
        i0, j0, heading = pose[b, 0] + half, pose[b, 1] + half, pose[b, 2] & 3
        for p in range(cells.shape[1]):
            if cells[b, p] < 0:
                continue
            di, dj = _turn(heading, cells[b, p] // columns - behind, cells[b, p] % columns - aside)
            i, j, row = i0 + di, j0 + dj, rows[b, p]
            if not (0 <= i < size and 0 <= j < size):
                continue
            if targets[b, row]:
                flags[b, i, j] |= TARGET
            track = tracks[b, row]
            if track < 0 or track >= extent.shape[1]:
                continue
            if opened[b, track]:
                flags[b, i, j] |= OPENED
            if track != who[b, 0, i, j] and track != who[b, 1, i, j]:
                _enter(who[b, :, i, j], track, mass[b], extent[b])


@merged
def _enter(there: I16, track: int, mass: F32, extent: I32) -> None:
    """Enter a track among those of a cell (2,); if there is no room, in place of one with less belief, if any."""
    at = 0 if there[0] < 0 else 1
    if at == 1 and there[1] >= 0:
        at = 0 if mass[there[0]].sum() < mass[there[1]].sum() else 1
        if mass[track].sum() <= mass[there[at]].sum():
            return
        extent[there[at]] -= 1
    there[at] = track
    extent[track] += 1


@jit
def measure_maps(flags: U8, look: U8, who: I16, share: F32, enough: U8, out: F32) -> None:
    """Sum up whole maps.

    Args:
        flags: (B, S, S).
        look: (B, S, S).
        who: (B, 2, S, S).
        share: (B, N, 4) belief of every track in each of its cells.
        enough: (B,) value of ``look`` from which a cell was seen closely enough to show the target.
        out: (B, 3) written: square metres explored, square metres of them not seen closely, belief in these.
    """
    size = flags.shape[1]
    for b in range(flags.shape[0]):
        explored, thin, fresh = 0, 0, np.float32(0.0)
        for i in range(size):
            for j in range(size):
                if not flags[b, i, j] & EXPLORED:
                    continue
                explored += 1
                if look[b, i, j] < enough[b]:
                    thin += 1
                    for layer in range(2):
                        if who[b, layer, i, j] >= 0:
                            fresh += share[b, who[b, layer, i, j]].sum()
        out[b, 0], out[b, 1], out[b, 2] = explored * _CELL_M2, thin * _CELL_M2, fresh
