"""Kernels of sample points: points under and next to a box, a template placed in a box, and which way a thing faces."""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I32, U8, Flags, jit, merged
from ucon.perception.mapping.map_kernels import ALL_OPEN, CELL_M

ONTOP, INSIDE, UNDER, NEXTTO = range(4)
#: Most points under and next to one thing.
MOST = 24
_SPACING_M = 0.5
#: Things smaller than this have one point next to them: a frame that shows the thing shows its surroundings. Metres.
SMALL_M = 0.45
#: Score taken off an orientation for a factor of e between the seen and the usual ratio of depth to width.
_MISMATCH = 0.7
#: Score that another orientation must be better by than the current one.
_STAYS = 0.25


@jit
def changed_boxes(box: F64, made: F64, kind: U8, opened: Flags, by_m: float, out: I32) -> int:
    """Find the things whose box changed since their points were made.

    Things never seen, structure, and opened things (their doors swing) are left out.

    Args:
        box: (n, 6) float64, x0 y0 z0 x1 y1 z1 of what was seen, metres.
        made: (n, 6) float64, the box at the time the points were made; inf before.
        kind: (n,) uint8, 0 for things.
        opened: (n,) bool.
        by_m: a side must have moved by more than this, metres.
        out: (n,) int32, written: row numbers.

    Returns:
        How many rows of ``out`` are written.
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
    """Place a template's k points and compartments in a box, turned.

    Args:
        xyz: (k, 3) of the ``Template``.
        lift: (k,) of the template.
        hollow: (k, 6) of the template.
        faces: (k,) uint8 of the template.
        box: (6,) x0 y0 z0 x1 y1 z1, metres.
        quarters: quarter turns counter-clockwise.
        lift_m: half the target's height, metres.
        rows: (k, 12) float64; written: columns 0 to 2, the point, and 6 to 11, its compartment, in metres.
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
    """Sample points under and next to a box.

    Args:
        box: (6,) x0 y0 z0 x1 y1 z1, metres.
        under: whether there is space below.
        height: (n, n) float32, the map's heights, metres.
        half: cell number of the start.
        out: (MOST, 5) float64, written: x, y, z, relation, share.

    Returns:
        How many rows are written.
    """
    n = _below(box, out) if under else 0
    return _around(box, height, half, out, n)


@merged
def _below(box: F64, out: F64) -> int:
    """Points on the floor below a box; returns how many."""
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
    """Points beside a box, on the floor or at the height it stands on; none where a wall or a tall thing stands.

    ``out`` has n rows already. Returns how many it has afterwards.
    """
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
    """Estimate by how many quarter turns each of n things is turned.

    A thing's front (+x at 0) faces free floor, its back faces a wall or unseen space, and its depth is not its width.
    The current estimate stays unless another one is clearly better.

    Args:
        boxes: (n, 6) float64, what was seen, metres.
        sizes: (n, 3) float64, catalogue sizes, metres.
        floor: (m, m) uint8, the map's floor.
        blocked: (m, m) uint8, the map's blocked nodes.
        walls: (2, m, m) uint8, the map's walls.
        half: cell number of the start.
        out: (n,) int32, updated: quarter turns counter-clockwise; -1 before the first estimate.

    Returns:
        How many estimates changed.
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
    """How free the floor in front of one side of a box is: 1 free, 0 unknown, -1 blocked by a thing, -2 by a wall."""
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
    """Find the points at which the next frame may show something new.

    Left out are replaced points, points that were shown well, and points inside closed containers.

    Args:
        track: (n,) int32.
        relation: (n,) int32.
        share: (n,) float64, 0 for replaced points.
        unseen: (n,) float64.
        shut: (T,) bool, closed containers by track.
        out: (n,) bool, written.
    """
    for n in range(track.shape[0]):
        hidden = relation[n] == INSIDE and shut[track[n]]
        out[n] = not hidden and unseen[n] > 1e-3 and share[n] > 0.0


@jit
def copy_unseen(
    new: F64, new_relation: I32, old: F64, old_relation: I32, old_unseen: F64, unseen: F64, old_looked: Any,
    looked: Any,
) -> None:  # fmt: skip
    """Copy ``unseen`` from old points of a thing to its new ones.

    A new point takes that of the nearest old point of its relation within 0.3 m, or within 0.1 m for points inside. The
    limit inside is smaller because the first frames may have shown only a strip of the thing, so that its inside was
    misplaced.

    Args:
        new: (a, 3) float64, metres.
        new_relation: (a,) int32.
        old: (b, 3) float64, metres.
        old_relation: (b,) int32.
        old_unseen: (b,) float64.
        unseen: (a,) float64, updated.
        old_looked: (b,) uint64, from where the old points were looked at.
        looked: (a,) uint64, updated in the same way.
    """
    for a in range(new.shape[0]):
        best = 0.1 if new_relation[a] == INSIDE else 0.3
        for b in range(old.shape[0]):
            if new_relation[a] != old_relation[b]:
                continue
            gap = max(abs(new[a, 0] - old[b, 0]), abs(new[a, 1] - old[b, 1]), abs(new[a, 2] - old[b, 2]))
            if gap < best:
                best = gap
                unseen[a], looked[a] = old_unseen[b], old_looked[b]
