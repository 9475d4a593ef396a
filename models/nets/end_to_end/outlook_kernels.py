"""Kernels that count what every pose around an agent would show, by rays over the map memory.

Few cells change from one step to the next, so counts are cached (:class:`KeptCounts`) until a cell that their rays may
read changes. The numbers are the same as without the cache.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from models.nets.end_to_end.ego_kernels import EXPLORED, OPAQUE
from models.nets.end_to_end.memory_kernels import TARGET
from models.nets.end_to_end.way_kernels import FAR
from ucon.core.jit import F32, I16, I32, U8, U16, jit, leaf, merged
from ucon.perception.views.space_kernels import RAY_AREA, RAY_CELL, RAYS

#: What is counted of every pose, see :data:`models.nets.end_to_end.floor_memory.OUTLOOK`.
N_OUTLOOK = 10
ON, BESIDE, INSIDE, USED, CLOSED, SPACE, THIN, TARGETED, BEEN, AROUND = range(N_OUTLOOK)
#: Cells of a ray (5.5 m).
_MOST: Final = 22
#: Weight of each further unexplored cell of a ray relative to the one before, and how many count.
_DEEPER, _DEEP_CELLS = np.float32(0.8825), 12
#: Distance in cells from which containers can be opened and the target can be taken.
_REACH_CELLS = 4
#: The target also shows where it was seen up to this many cells behind something opaque: between the boards of a shelf.
_DEPTH_CELLS = 2
_CELL_M2 = 0.0625
#: Bits of a cell of the window, as rays read it.
_KNOWN, _END, _AIM, _FRESH, _HOLDS, _SHUT = 1, 2, 4, 8, 16, 32
_COUNTS = _AIM | _FRESH | _HOLDS
#: How many counts rays make (the first ones), and how many numbers of a cell they read besides its bits.
_BY_RAYS: Final = 8
_N_READ: Final = 8
#: If more cells than this differ, everything is counted again.
_MOST_CHANGED: Final = 400


def _fans() -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.int32], NDArray[np.int32], int]:
    """The rays of each heading, in the order in which they are read.

    Returns:
        Offsets (4, R, _MOST, 2) int32 of the cells of R rays; the square metres (4, R, _MOST) float32 that each stands
        for; a number (4, R, _MOST) int32 of each cell among those of its heading; how many of its first cells (4, R)
        int32 each ray shares with the ray before it; and the largest number of cells of a heading.
    """
    heading = ((np.arange(RAYS) + RAYS // 8) % RAYS) // (RAYS // 4)
    order = np.stack([np.flatnonzero(heading == h) for h in range(4)])
    cell, area = RAY_CELL[order][:, :, :_MOST], RAY_AREA[order][:, :, :_MOST]
    number = np.stack(
        [np.unique(fan.reshape(-1, 2), axis=0, return_inverse=True)[1].reshape(-1, _MOST) for fan in cell]
    )
    alike = (cell[:, 1:] == cell[:, :-1]).all(-1).cumprod(-1).sum(-1)
    same = np.concatenate([np.zeros((4, 1), np.int64), alike], 1)
    # Contiguous, so that they become constants of the kernels.
    whole = np.ascontiguousarray(cell, np.int32), np.ascontiguousarray(area, np.float32)
    return *whole, np.ascontiguousarray(number, np.int32), np.ascontiguousarray(same, np.int32), int(number.max()) + 1


_CELL, _AREA, _NUMBER, _SAME, _N_CELLS = _fans()


def _cells_of_fans() -> NDArray[np.int32]:
    """(4, _N_CELLS, 2) int32, offsets of all cells that the rays of each heading may read; the last ones repeated."""
    fans = [np.unique(fan.reshape(-1, 2), axis=0) for fan in _CELL]
    return np.stack([np.pad(fan, ((0, _N_CELLS - len(fan)), (0, 0)), "edge") for fan in fans])


_READ = _cells_of_fans()


class KeptCounts:
    """Cache of :func:`look_out`: counts of the poses of a batch of episodes, and the cells that their rays read.

    It changes how fast :func:`look_out` is, never what it finds: whatever maps come next, poses whose rays may read a
    changed cell are counted again. So it is not part of any state, and copies of it are empty.

    Args:
        size: cells of a side of a map.
    """

    def __init__(self, size: int) -> None:
        self._size, self._rows = size, 0

    def __deepcopy__(self, memo: Mapping[int, Any]) -> KeptCounts:
        return KeptCounts(self._size)

    def __reduce__(self) -> tuple[type[KeptCounts], tuple[int]]:
        return KeptCounts, (self._size,)

    def of(self, n: int) -> tuple[U8, F32, U8, F32, I32]:
        """Arrays of the first ``n`` episodes, read and written by :func:`look_out`.

        Returns:
            Which headings of each cell are counted (n, S, S), as bits; their counts (n, S, S, 4, 8), which take up
            memory only where they are written; the bits (n, S, S) and numbers (n, S, S, 8) of each cell that rays read;
            and ``sight`` and ``enough`` (n, 2) that the counts are valid for.
        """
        if n > self._rows:
            shape = (n, self._size, self._size)
            self._rows, self._held, self._bits = n, np.zeros(shape, np.uint8), np.zeros(shape, np.uint8)
            self._counts = np.empty((*shape, 4, _BY_RAYS), np.float32)
            self._read = np.empty((*shape, _N_READ), np.float32)
            self._sight = np.full((n, 2), -1, np.int32)
        return self._held[:n], self._counts[:n], self._bits[:n], self._read[:n], self._sight[:n]


@jit
def look_out(  # noqa: C901 (one loop over poses; parts of it would be called for each of them)
    flags: U8, look: U8, who: I16, visits: U8, share: F32, extent: I32, pose: I32, sight: I32, enough: U8, steps: U8,
    cell: U8, patience: int, kept: tuple[U8, F32, U8, F32, I32], out: F32,
) -> None:  # fmt: skip
    """Count what each pose that can be reached would show.

    Args:
        flags: (B, S, S).
        look: (B, S, S).
        who: (B, 2, S, S).
        visits: (B, 4, S, S).
        share: (B, N, 4) belief of every track in each of its cells: on it, beside or under it, in it, behind its closed
            doors.
        extent: (B, N) cells of every track.
        pose: (B, 4).
        sight: (B,) how many cells away the target would be seen.
        enough: (B,) value of ``look`` from which a cell was seen closely enough to show it.
        steps: (B, 4, C, C) of :func:`find_ways`.
        cell: (B, C, C) of :func:`find_ways`.
        patience: a pose that the agent has spent this many steps in counts as showing nothing more.
        kept: of :meth:`KeptCounts.of`, read and written.
        out: (B, N_OUTLOOK, 4, C, C) written, 0 where there is no way.
    """
    held, kept_counts, bits, read, ranges = kept
    size, coarse = flags.shape[1], cell.shape[1]
    half, reach = size // 2, coarse - 1
    side = 2 * (coarse + _MOST)
    window, mass = np.empty((side, side), np.uint8), np.zeros((side, side, 4), np.float32)
    counted, asked = np.zeros(_N_CELLS, np.uint16), np.zeros(extent.shape[1], np.int32)
    changed = np.empty((_MOST_CHANGED, 2), np.int32)
    found = np.zeros((N_OUTLOOK, 4), np.float32)
    mark = 0
    out[:] = 0.0
    for b in range(flags.shape[0]):
        i0, j0 = pose[b, 0] + half - reach - _MOST, pose[b, 1] + half - reach - _MOST
        shown = _open_window(i0, j0, flags[b], look[b], who[b], enough[b], window)
        deep_cells = _DEPTH_CELLS if shown else 0
        _lay_out(i0, j0, who[b], share[b], window, mass)
        things = (i0, j0, who[b], share[b], extent[b])
        n_changed = _changes(things, window, mass, bits[b], read[b], changed)
        if ranges[b, 0] != sight[b] or ranges[b, 1] != enough[b]:
            ranges[b, 0], ranges[b, 1], n_changed = sight[b], enough[b], _MOST_CHANGED + 1
        _forget(changed, n_changed, held[b])
        for a in range(coarse):
            for c in range(coarse):
                if steps[b, 0, a, c] == FAR:
                    continue
                u, v = _MOST + 2 * a + (cell[b, a, c] >> 1), _MOST + 2 * c + (cell[b, a, c] & 1)
                i, j = i0 + u, j0 + v
                if not (0 < i < size - 1 and 0 < j < size - 1):
                    continue
                beside = window[u - 1, v] | window[u + 1, v] | window[u, v - 1] | window[u, v + 1]
                if not (window[u, v] | beside) & _KNOWN:
                    continue
                for h in range(4):
                    if visits[b, h, i, j] >= patience:
                        found[:, h] = 0.0
                        continue
                    if not held[b, i, j] >> h & 1:
                        mark += 1
                        if mark & 0xFFFF == 0:  # marks start again, and 0 is not a mark
                            counted[:] = 0
                            mark += 1
                        _look_from(u, v, h, (window, mass), things, sight[b], deep_cells, counted, asked, mark, found)
                        held[b, i, j] |= 1 << h
                        for k in range(_BY_RAYS):
                            kept_counts[b, i, j, h, k] = found[k, h]
                    else:
                        for k in range(_BY_RAYS):
                            found[k, h] = kept_counts[b, i, j, h, k]
                _been(i, j, visits[b], found)
                for k in range(N_OUTLOOK):
                    for h in range(4):
                        out[b, k, h, a, c] = found[k, h]


@leaf
def _open_window(i0: int, j0: int, flags: U8, look: U8, who: I16, enough: int, window: U8) -> bool:
    """Write the bits that rays read of the cells around an agent; cells beyond the map are unexplored.

    Args:
        i0: row of the map's cell in the window's corner.
        j0: its column.
        flags: (S, S).
        look: (S, S).
        who: (2, S, S).
        enough: value of ``look`` from which a cell was seen closely enough to show the target.
        window: (W, W) written: ``_KNOWN`` for explored, ``_END`` for opaque, ``_AIM`` for the target, ``_FRESH`` for
            not seen closely, ``_HOLDS`` for a cell with things.

    Returns:
        Whether the target was seen in one of them.
    """
    size, shown = flags.shape[0], 0
    window[:] = 0
    first, last = max(0, -j0), min(window.shape[1], size - j0)
    for u in range(max(0, -i0), min(window.shape[0], size - i0)):
        for v in range(first, last):  # without branches, so that many cells are done at once
            i, j = i0 + u, j0 + v
            known, end, aim = flags[i, j] & EXPLORED != 0, flags[i, j] & OPAQUE != 0, flags[i, j] & TARGET != 0
            holds = (who[0, i, j] >= 0) | (who[1, i, j] >= 0)
            shown |= aim
            window[u, v] = known * _KNOWN | end * _END | aim * _AIM | (look[i, j] < enough) * _FRESH | holds * _HOLDS
    return shown != 0


@leaf
def _lay_out(i0: int, j0: int, who: I16, share: F32, window: U8, mass: F32) -> None:
    """Write the belief in each cell of a window: on, beside and in its things, or their sum if it was seen closely.

    Args:
        i0: row of the map's cell in the window's corner.
        j0: its column.
        who: (2, S, S).
        share: (N, 4).
        window: (W, W) of :func:`_open_window`; ``_SHUT`` is added where some belief is behind closed doors.
        mass: (W, W, 4) written where the window holds things.
    """
    for u in range(window.shape[0]):
        for v in range(window.shape[1]):
            if not window[u, v] & _HOLDS:
                continue
            on, beside, inside, shut = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for layer in range(2):
                track = who[layer, i0 + u, j0 + v]
                if track >= 0:
                    on += share[track, 0]
                    beside += share[track, 1]
                    inside += share[track, 2]
                    shut += share[track, 3]
            if shut > 0:
                window[u, v] |= _SHUT
            fresh = window[u, v] & _FRESH != 0
            mass[u, v, 0] = on if fresh else np.float32(0.0)
            mass[u, v, 1] = beside if fresh else np.float32(0.0)
            mass[u, v, 2] = inside if fresh else np.float32(0.0)
            mass[u, v, 3] = np.float32(0.0) if fresh else on + beside + inside


@leaf
def _changes(things: Any, window: U8, mass: F32, bits: U8, read: F32, changed: I32) -> int:
    """Note which cells of a window differ from what rays read there before.

    Args:
        things: the window's corner (i, j), who, share and extent of one map.
        window: (W, W) of :func:`_open_window`.
        mass: (W, W, 4) of :func:`_lay_out`.
        bits: (S, S) read and written: the window's bits when the cell was last in one.
        read: (S, S, _N_READ) read and written: the other numbers of the cell then, if it holds things.
        changed: (_MOST_CHANGED, 2) written: cells of the map that differ.

    Returns:
        How many differ; ``changed`` holds as many of them as fit.
    """
    i0, j0, who, share, extent = things
    size, n = bits.shape[0], 0
    first, last = max(0, -j0), min(window.shape[1], size - j0)
    for u in range(max(0, -i0), min(window.shape[0], size - i0)):
        for v in range(first, last):
            i, j = i0 + u, j0 + v
            now = window[u, v]
            if now == bits[i, j] and not now & _HOLDS:
                continue
            differs = now != bits[i, j]
            bits[i, j] = now
            if now & _HOLDS:
                for k in range(4):
                    differs |= read[i, j, k] != mass[u, v, k]
                    read[i, j, k] = mass[u, v, k]
                for layer in range(2):
                    track = who[layer, i, j]
                    behind = share[track, 3] * np.float32(extent[track]) if track >= 0 else np.float32(0.0)
                    differs |= read[i, j, 4 + layer] != track or read[i, j, 6 + layer] != behind
                    read[i, j, 4 + layer], read[i, j, 6 + layer] = track, behind
            if differs:
                if n < changed.shape[0]:
                    changed[n, 0], changed[n, 1] = i, j
                n += 1
    return n


@leaf
def _forget(changed: I32, n: int, held: U8) -> None:
    """Drop what is kept of poses whose rays may read a cell that changed.

    Args:
        changed: cells of :func:`_changes`.
        n: how many differ; if ``changed`` does not hold them all, everything is dropped.
        held: (S, S) which headings of each cell are kept, as bits.
    """
    size = held.shape[0]
    if n > changed.shape[0]:
        held[:] = 0
        return
    for one in range(n):
        for h in range(4):
            others = np.uint8(0xFF ^ 1 << h)
            for k in range(_READ.shape[1]):
                i, j = changed[one, 0] - _READ[h, k, 0], changed[one, 1] - _READ[h, k, 1]
                if 0 <= i < size and 0 <= j < size:
                    held[i, j] &= others


@leaf
def _look_from(  # noqa: C901 (one loop over the cells of rays; parts of it would be called for every cell)
    u0: int,
    v0: int,
    h: int,
    seen: Any,
    things: Any,
    sight: int,
    deep_cells: int,
    counted: U16,
    asked: I32,
    mark: int,
    out: F32,
) -> None:
    """Count what a node would show in a heading; cells and containers count once.

    The first cells that a ray shares with the ray before it are not read again, as far as they are explored and clear.

    Args:
        u0: row of the node in the window.
        v0: its column.
        h: the heading.
        seen: (W, W) of :func:`_open_window`, and (W, W, 4) of :func:`_lay_out`.
        things: the window's corner (i, j), who, share and extent of one map.
        sight: how many cells away the target would be seen.
        deep_cells: how many cells behind something opaque it counts.
        counted: (_N_CELLS,) scratch: the last node and heading that counted each cell.
        asked: (N,) scratch, the same for containers.
        mark: number of the node and heading, from 1.
        out: (N_OUTLOOK, 4), column ``h`` written.
    """
    window, mass = seen
    space, aim, fresh, clear = np.float32(0.0), np.float32(0.0), 0, 0
    on, beside, inside, used = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
    out[CLOSED, h] = 0.0
    label = np.uint16(mark & 0xFFFF)
    for ray in range(_CELL.shape[1]):
        start = min(_SAME[h, ray], abs(clear))
        if clear < 0 and start == -clear:  # it ends where the ray before ended
            aim = max(aim, _behind(u0, v0, h, ray, start - 1, window, deep_cells))
            continue
        trust, deep, clear = np.float32(1.0), 0, start
        for k in range(start, _MOST):
            u, v = u0 + _CELL[h, ray, k, 0], v0 + _CELL[h, ray, k, 1]
            bits = window[u, v]
            if not bits & _KNOWN:
                if not bits & _END:
                    space += _AREA[h, ray, k] * trust
                    trust *= _DEEPER
                    deep += 1
            else:
                if clear == k:
                    clear = k + 1
                if bits & _COUNTS and counted[_NUMBER[h, ray, k]] != label:
                    counted[_NUMBER[h, ray, k]] = label
                    if k < sight and bits & _FRESH:
                        fresh += 1
                    if bits & _HOLDS:
                        if k < sight:
                            on += mass[u, v, 0]
                            beside += mass[u, v, 1]
                            inside += mass[u, v, 2]
                            used += mass[u, v, 3]
                        if k < _REACH_CELLS and bits & _SHUT:
                            out[CLOSED, h] += _closed(u, v, things, asked, mark)
                    if bits & _AIM:
                        aim = max(aim, _aim(k))
            if bits & _END:
                if clear == k + 1:
                    clear = -clear
                aim = max(aim, _behind(u0, v0, h, ray, k, window, deep_cells))
                break
            if deep >= _DEEP_CELLS:
                break
    out[ON, h], out[BESIDE, h], out[INSIDE, h], out[USED, h] = on, beside, inside, used
    out[SPACE, h], out[TARGETED, h], out[THIN, h] = space, aim, np.float32(_CELL_M2) * np.float32(fresh)


@merged
def _aim(k: int) -> np.float32:
    """Weight of a target in the k-th cell of a ray, counted from 0."""
    return np.float32(1.0 if k < _REACH_CELLS else 2.0 / (k + 1))


@leaf
def _behind(u0: int, v0: int, h: int, ray: int, end: int, window: U8, most: int) -> np.float32:
    """Weight of a target that was seen up to ``most`` cells behind the opaque cell in which a ray ends."""
    for k in range(end + 1, min(end + 1 + most, _MOST)):
        if window[u0 + _CELL[h, ray, k, 0], v0 + _CELL[h, ray, k, 1]] & _AIM:
            return _aim(k)
    return np.float32(0.0)


@leaf
def _closed(u: int, v: int, things: Any, asked: I32, mark: int) -> np.float32:
    """Belief behind the closed doors of what is in a cell, once for each container."""
    i0, j0, who, share, extent = things
    belief = np.float32(0.0)
    for layer in range(2):
        track = who[layer, i0 + u, j0 + v]
        if track >= 0 and share[track, 3] > 0 and asked[track] != mark:
            asked[track] = mark
            belief += share[track, 3] * np.float32(extent[track])
    return belief


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
