"""Sample points under and next to one box, and which way it stands turned."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I32, U8, Flags, jit, merged
from ucon.perception.mapping.map_kernels import ALL_OPEN, CELL_M

ONTOP, INSIDE, UNDER, NEXTTO = range(4)
#: Most points under and next to one thing.
MOST = 24
_SPACING_M = 0.5
#: Things smaller than this have one point next to them: whoever sees the thing sees what stands by it.
SMALL_M = 0.45
#: What a factor of e between the seen and the usual ratio of depth to width speaks against a turn.
_MISMATCH = 0.7
#: How much likelier another turn must be than the one believed before.
_STAYS = 0.25


@jit
def grown(box: F64, made: F64, kind: U8, opened: Flags, by_m: float, out: I32) -> int:
    """Write to out (n,) the things of whose box (n, 6) a side moved by more than ``by_m`` from ``made`` (n, 6).

    Only what was seen and is not open. Returns how many there are.
    """
    count = 0
    for n in range(box.shape[0]):
        if kind[n] != 0 or opened[n] or box[n, 3] < box[n, 0]:
            continue
        for k in range(6):
            if abs(box[n, k] - made[n, k]) > by_m:
                out[count] = n
                count += 1
                break
    return count


@jit
def stretch(xyz: F64, lift: F64, hollow: F64, faces: U8, box: F64, quarters: int, lift_m: float, rows: F64) -> None:
    """Write columns 0 to 2 and 6 to 11 of rows (k, 12): the points and hollows of a template in a box, turned.

    xyz (k, 3), lift (k,), hollow (k, 6) and faces (k,) are those of a ``Template``.
    """
    c, s = (1.0, 0.0, -1.0, 0.0)[quarters], (0.0, 1.0, 0.0, -1.0)[quarters]
    wide, deep, high = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    if quarters % 2 == 1:
        wide, deep = deep, wide
    cx, cy = 0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4])
    for k in range(rows.shape[0]):
        row, x, y = rows[k], xyz[k, 0] * wide, xyz[k, 1] * deep
        row[0], row[1] = c * x - s * y + cx, s * x + c * y + cy
        row[2] = xyz[k, 2] * high + box[2] + max(lift[k] * lift_m, 0.02)
        x0, y0, x1, y1 = hollow[k, 0] * wide, hollow[k, 1] * deep, hollow[k, 3] * wide, hollow[k, 4] * deep
        ax, bx, ay, by = c * x0 - s * y0 + cx, c * x1 - s * y1 + cx, s * x0 + c * y0 + cy, s * x1 + c * y1 + cy
        az, bz = hollow[k, 2] * high + box[2], hollow[k, 5] * high + box[2]
        row[6], row[7], row[8] = min(ax, bx), min(ay, by), min(az, bz)
        row[9], row[10], row[11] = max(ax, bx), max(ay, by), max(az, bz)
        if faces[k] != ALL_OPEN:
            row[2] = min(row[2], 0.5 * (row[8] + row[11]))


@jit
def make_points(box: F64, under: bool, height: F32, half: int, out: F64) -> int:
    """Write rows (x, y, z, relation, share) of places under and next to a box into out (MOST, 5); returns how many.

    ``height`` is the map's.
    """
    n = _below(box, out) if under else 0
    return _around(box, height, half, out, n)


@merged
def _below(box: F64, out: F64) -> int:
    wide, deep = box[3] - box[0], box[4] - box[1]
    nx, ny = min(max(int(np.round(wide / _SPACING_M)), 1), 3), min(max(int(np.round(deep / _SPACING_M)), 1), 3)
    for a in range(nx):
        for b in range(ny):
            n = a * ny + b
            out[n, 0], out[n, 1] = box[0] + (a + 0.5) * wide / nx, box[1] + (b + 0.5) * deep / ny
            out[n, 2], out[n, 3], out[n, 4] = 0.08, UNDER, 1.0 / (nx * ny)
    return nx * ny


@merged
def _around(box: F64, height: F32, half: int, out: F64, n: int) -> int:
    """Points beside a box, on the floor or on what it stands on; none where a wall or a tall thing stands."""
    x0, y0, z0, x1, y1, z1 = box
    cx, cy, wide, deep = 0.5 * (x0 + x1), 0.5 * (y0 + y1), x1 - x0, y1 - y0
    if max(wide, deep) < SMALL_M:
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = cx, cy, z1 + 0.02, NEXTTO, 1.0
        return n + 1
    z = 0.1 if z0 < 0.4 else z0 + 0.08
    bar = 9.0 if z1 > 1.4 else 1.5
    first = n
    for side in range(4):
        length = deep if side < 2 else wide
        pieces = 2 if length > 1.2 else 1
        for k in range(pieces):
            t = (k + 0.5) / pieces
            if side < 2:
                px, py = (x0 - 0.15 if side == 0 else x1 + 0.15), y0 + t * deep
            else:
                px, py = x0 + t * wide, (y0 - 0.15 if side == 2 else y1 + 0.15)
            i, j = int(np.floor(px / CELL_M + 0.5)) + half, int(np.floor(py / CELL_M + 0.5)) + half
            if 0 <= i < height.shape[0] and 0 <= j < height.shape[1] and height[i, j] < bar:
                out[n, 0], out[n, 1], out[n, 2], out[n, 3] = px, py, z, NEXTTO
                n += 1
    if n == first:
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = cx, cy, z1 + 0.02, NEXTTO
        n += 1
    for k in range(first, n):
        out[k, 4] = 1.0 / (n - first)
    return n


@jit
def facing(boxes: F64, sizes: F64, floor: U8, blocked: U8, walls: U8, half: int, out: I32) -> int:
    """Write to out (n,) the quarter turns by which things (n, 6) of catalogue sizes (n, 3) most likely stand turned.

    Their front (+x at 0) looks at free floor, their back at a wall or at nothing that was seen; and depth is not width.
    ``out`` holds the turns believed so far (-1 none), which stay unless another is clearly likelier. Returns how many
    changed.
    """
    side, changed = np.zeros(4), 0
    for n in range(boxes.shape[0]):
        box = boxes[n]
        for k in range(4):
            side[k] = _freedom(box, k, floor, blocked, walls, half)
        wide, deep = max(box[3] - box[0], 0.05), max(box[4] - box[1], 0.05)
        tilt = np.log((wide / deep) / (sizes[n, 0] / sizes[n, 1]))
        flat = np.log((wide / deep) / (sizes[n, 1] / sizes[n, 0]))
        best, before = -1e9, out[n]
        for q in range(4):
            score = side[q] - 0.5 * side[(q + 2) % 4] - _MISMATCH * min(abs(tilt if q % 2 == 0 else flat), 1.5)
            score += _STAYS if q == before else 0.0
            if score > best + 1e-9:
                best, out[n] = score, q
        changed += out[n] != before
    return changed


@merged
def _freedom(box: F64, q: int, floor: U8, blocked: U8, walls: U8, half: int) -> float:
    """How free the floor before one side is: 1 free, 0 unknown, -1 blocked by a thing, -2 by a wall."""
    total = 0.0
    for piece in range(3):
        t = 0.25 + 0.25 * piece
        if q % 2 == 0:
            x, y, dx, dy = (box[3] if q == 0 else box[0]), box[1] + t * (box[4] - box[1]), 1.0 - q, 0.0
        else:
            x, y, dx, dy = box[0] + t * (box[3] - box[0]), (box[4] if q == 1 else box[1]), 0.0, 2.0 - q
        i, j = (
            int(np.floor((x - 0.05 * dx) / CELL_M + 0.5)) + half,
            int(np.floor((y - 0.05 * dy) / CELL_M + 0.5)) + half,
        )
        for step in range(1, 5):
            d = 0.15 * step
            a, b = int(np.floor((x + d * dx) / CELL_M + 0.5)) + half, int(np.floor((y + d * dy) / CELL_M + 0.5)) + half
            if a < 1 or b < 1 or a >= floor.shape[0] - 1 or b >= floor.shape[1] - 1:
                break
            if (a != i and walls[0, min(i, a), b] > 0) or (b != j and walls[1, a, min(j, b)] > 0):
                total -= 2.0
                break
            if step >= 3:
                total += 0.5 * (-1.0 if blocked[a, b] > 0 else 1.0 if floor[a, b] > 0 else 0.0)
            i, j = a, b
    return total / 3.0


@jit
def searched(track: I32, relation: I32, share: F64, unseen: F64, shut: Flags, out: Flags) -> None:
    """Write to out (n,) which points may show something new: live, not seen well yet, not inside what is shut (T,)."""
    for n in range(track.shape[0]):
        hidden = relation[n] == INSIDE and shut[track[n]]
        out[n] = not hidden and unseen[n] > 1e-3 and share[n] > 0.0


@jit
def inherit(new: F64, old: F64, old_unseen: F64, unseen: F64) -> None:
    """Give new points the ``unseen`` of the nearest old point of their relation within 0.3 m, 0.1 m inside of things.

    What was seen of a thing at first may have been a strip; where its inside is, is known late.
    """
    for a in range(new.shape[0]):
        best = 0.1 if new[a, 3] == INSIDE else 0.3
        for b in range(old.shape[0]):
            if new[a, 3] != old[b, 3]:
                continue
            gap = max(abs(new[a, 0] - old[b, 0]), abs(new[a, 1] - old[b, 1]), abs(new[a, 2] - old[b, 2]))
            if gap < best:
                best = gap
                unseen[a] = old_unseen[b]
