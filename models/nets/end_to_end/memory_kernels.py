"""Kernels of the map memory: what a frame writes into it, the ways through it, and what poses on it would show.

All work on B maps at once. A map is a grid of cells of 0.25 m; cell (i, j) lies i ahead and j to the left of where the
agent started. Headings are quarter turns to the left: 0 looks along i, 1 along j.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.nets.end_to_end.ego_kernels import BLOCKED, EXPLORED, OPAQUE
from ucon.core.jit import F32, I16, I32, U8, jit, merged

#: Further bits of a cell, beside those of a frame: the target was seen in it, something in it was opened, the agent
#: stood there.
TARGET, OPENED, VISITED = 16, 32, 64
#: Distance of poses that cannot be reached, or not within 254 actions; and the first action of the pose it is in.
FAR, STAY = 255, 3
#: What is counted of every pose, see :data:`models.nets.end_to_end.floor_memory.OUTLOOK`.
N_OUTLOOK = 10
ON, BESIDE, INSIDE, USED, CLOSED, SPACE, THIN, TARGETED, BEEN, AROUND = range(N_OUTLOOK)
#: Rays of a full turn, and cells of a ray (5.5 m).
_RAYS, _MOST = 64, 22
#: Weight of each further unexplored cell of a ray relative to the one before, and how many count.
_DEEPER, _DEEP_CELLS = np.float32(0.8825), 12
#: Containers can be opened from so many cells away, and the target is taken from there.
_REACH_CELLS = 4
_CELL_M2 = 0.0625


def _rays() -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Cells (RAYS, MOST, 2) of each ray relative to where it begins, and the square metres that each stands for."""
    angle = 2.0 * np.pi * (np.arange(_RAYS) + 0.5) / _RAYS
    k = np.arange(1, _MOST + 1)
    way = np.stack([np.cos(angle), np.sin(angle)], 1)[:, None] * k[:, None]
    cell = np.floor(way + 0.5).astype(np.int32)
    area = np.tile(k * _CELL_M2 * 2.0 * np.pi / _RAYS, (_RAYS, 1))
    area[:, 1:][(cell[:, 1:] == cell[:, :-1]).all(-1)] = 0.0
    return cell, area.astype(np.float32)


_CELL, _AREA = _rays()


@merged
def _turn(heading: int, f: int, left: int) -> tuple[int, int]:
    """Cells along i and j of what lies ``f`` ahead and ``left`` to the left of an agent with this heading."""
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
    """Write which things are in which cell: where there are more than two, those with the most belief.

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
    """Enter a track among those of a cell (2,), in place of the one with less belief if there is no room."""
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
        enough: (B,) what was seen as closely as this would have shown the target.
        out: (B, 3) written: square metres explored, square metres of them not seen closely, belief not looked at.
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


@jit
def _search(ok: U8, width: int, start: int, steps: U8, first: U8, queue: I32) -> None:
    """Breadth-first search over states 4 * cell + heading.

    Args:
        ok: (W * W,) 1 for cells that may be stood on; the border has to be 0.
        width: W.
        start: state of the agent.
        steps: (4 * W * W,) is filled with distances.
        first: (4 * W * W,) is filled with first actions.
        queue: (4 * W * W,) scratch memory.
    """
    steps[:] = FAR
    steps[start], first[start] = 0, STAY
    queue[0], head, tail = start, 0, 1
    while head < tail:
        state = queue[head]
        head += 1
        d = steps[state]
        if d == FAR - 1:
            break
        h = state & 3
        ahead = 4 * width if h == 0 else (4 if h == 1 else (-4 * width if h == 2 else -4))
        for action in range(3):
            new = state + ahead if action == 0 else (state & ~3) | ((h + (3 if action == 1 else 1)) & 3)
            if steps[new] == FAR and (action != 0 or ok[new >> 2] != 0):
                steps[new] = d + 1
                first[new] = action if d == 0 else first[state]
                queue[tail] = new
                tail += 1


@jit
def find_ways(flags: U8, pose: I32, reach: int, steps: U8, first: U8, cell: U8) -> None:
    """Shortest ways to the poses around each agent, in blocks of 2 x 2 cells.

    Moves and turns cost one action each, as in the task. Of each block the cell that is reached soonest stands for all.

    Args:
        flags: (B, S, S); a cell that is blocked can be entered only if the agent stood there before.
        pose: (B, 4).
        reach: cells to each side of the agent.
        steps: (B, 4, C, C) written: actions to each pose, ``FAR`` where there is no way; C = reach + 1.
        first: (B, 4, C, C) written: first action of that way, ``STAY`` where it is.
        cell: (B, C, C) written: which of the block's cells, 2 * row + column.
    """
    size, side = flags.shape[1], 2 * reach + 1
    half, width, coarse = size // 2, side + 3, reach + 1
    queue = np.empty(4 * width * width, np.int32)
    fine, label = np.empty(4 * width * width, np.uint8), np.empty(4 * width * width, np.uint8)
    ok = np.zeros((width, width), np.uint8)
    start = (reach + 1) * width + reach + 1
    for b in range(flags.shape[0]):
        i0, j0 = pose[b, 0] + half - reach, pose[b, 1] + half - reach
        for a in range(side):
            for c in range(side):
                i, j = i0 + a, j0 + c
                inside = 0 <= i < size and 0 <= j < size
                ok[a + 1, c + 1] = not inside or not flags[b, i, j] & BLOCKED or flags[b, i, j] & VISITED
        _search(ok.reshape(-1), width, 4 * start + (pose[b, 2] & 3), fine, label, queue)
        for a in range(coarse):
            for c in range(coarse):
                corner = (2 * a + 1) * width + 2 * c + 1
                best, soonest = 0, 4 * FAR
                for k in range(4):
                    at = 4 * (corner + (k >> 1) * width + (k & 1))
                    sum_ = int(fine[at]) + int(fine[at + 1]) + int(fine[at + 2]) + int(fine[at + 3])
                    if sum_ < soonest:
                        best, soonest = k, sum_
                cell[b, a, c] = best
                at = 4 * (corner + (best >> 1) * width + (best & 1))
                for h in range(4):
                    steps[b, h, a, c], first[b, h, a, c] = fine[at + h], label[at + h]


@jit
def look_out(
    flags: U8, look: U8, who: I16, visits: U8, share: F32, extent: I32, pose: I32, sight: I32, enough: U8, steps: U8,
    cell: U8, out: F32,
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
    for ray in range(_RAYS):
        h = ((ray + _RAYS // 8) % _RAYS) // (_RAYS // 4)
        trust, deep = np.float32(1.0), 0
        for k in range(_MOST):
            i, j = i0 + _CELL[ray, k, 0], j0 + _CELL[ray, k, 1]
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
