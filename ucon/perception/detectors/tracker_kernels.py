"""Kernels of the tracker: the pixels of the thing in a box, and what the remaining pixels are by geometry.

The camera is that of :mod:`ucon.perception.mapping.map_kernels`; heights are metres above the floor.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, U8, Flags, jit, merged
from ucon.perception.mapping.map_kernels import CELL_M, FAR_M

#: Points below the first height are floor, above the second ceiling (metres).
FLOOR_M, CEILING_M = 0.05, 2.2
#: An upright plane above this height is a wall: apart from wardrobes no furniture of the catalogue is so high.
ABOVE_FURNITURE_M = 1.95
#: The depth histogram: bins of 5 % each, from 0.1 m on.
_STEP, _NEAREST_M, _BINS = np.log(1.05), 0.1, 140
FLOORS, WALLS, CEILINGS, OBSTACLES = 0, 1, 2, 3
#: Three pixels in a row lie on one plane if their inverse depths are linear up to this share.
PLANE_TOLERANCE = np.float32(1e-3)
#: A plane patch belongs to what is behind a box if less than this share of it lies in the box, unless less than
#: LEAST_LEFT of the box would be left.
MOSTLY, LEAST_LEFT = 0.9, 0.15


@merged
def _point(u: int, v: int, d: float, rows: int, columns: int, camera: F64) -> tuple[float, float, float]:
    """The point that pixel (u, v) shows at depth ``d``: x, y, z in metres in the start frame."""
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    up = (0.5 * rows - v - 0.5) / focal_px
    f, right = d * (cp - sp * up), d * ((u + 0.5 - 0.5 * columns) / focal_px)
    return x + c * f + s * right, y + s * f - c * right, cam_z + d * (sp + cp * up)


@jit
def main_depth(depth: F32, box: I32, mask: Flags, plane: I32, behind: Flags) -> float:
    """The most common depth in a box, in metres; 0 if the box shows nothing.

    Only the inner half of the box counts, or all of it where the inner half shows nothing.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        box: (4,) int32, pixels within the frame; right and bottom exclusive.
        mask: (H, W) bool, the thing's pixels; (0, 0) for a detector without masks.
        plane: (H, W) int32, plane patch of every pixel.
        behind: (n,) bool, patches that go on beyond the box: they are left out. Not read with a mask.
    """
    count = np.zeros(_BINS, np.int32)
    for inner in (True, False):
        dx = (box[2] - box[0]) // 4 if inner else 0
        dy = (box[3] - box[1]) // 4 if inner else 0
        for v in range(box[1] + dy, box[3] - dy):
            for u in range(box[0] + dx, box[2] - dx):
                d = depth[v, u]
                if 0.0 < d < FAR_M and (mask[v, u] if mask.shape[0] > 0 else not behind[plane[v, u]]):
                    count[min(max(int(np.log(d / _NEAREST_M) / _STEP), 0), _BINS - 1)] += 1
        if count.max() > 0:
            break
    best, most = -1, 0
    for k in range(_BINS):
        near = count[k] + count[max(k - 1, 0)] + count[min(k + 1, _BINS - 1)]
        if count[k] > 0 and near > most:
            best, most = k, near
    return _NEAREST_M * np.exp((best + 0.5) * _STEP) if best >= 0 else 0.0


@jit
def planes(depth: F32, plane: I32) -> int:
    """Cut a frame into plane patches: neighbouring pixels whose inverse depth is linear, as that of a plane is.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        plane: (H, W) int32, written: number of the patch of every pixel, from 0.

    Returns:
        How many patches there are.
    """
    rows, columns = depth.shape
    across, along = np.ones((rows, columns), np.uint8), np.ones((rows, columns), np.uint8)
    _bends(depth, across, along)
    root, beside, below = np.empty(rows * columns, np.int32), False, False
    for v in range(rows):
        run = v * columns
        for u in range(columns):  # runs of a row first: a join costs more
            if u > 0 and across[v, u - 1] and across[v, u]:
                run = v * columns + u
            root[v * columns + u] = run
        if v == 0:
            continue
        below = False
        for u in range(columns):
            here = v * columns + u
            known = below and root[here] != here  # joined with the pixel above already, one pixel to the left
            beside = u > 0 and (across[v - 1, u - 1] == 0 or across[v - 1, u] == 0)
            below = along[v - 1, u] == 0 or along[v, u] == 0
            if below and not (known and beside and (across[v, u - 1] == 0 or across[v, u] == 0)):
                _join(root, here - columns, here)
    n, flat = 0, plane.reshape(rows * columns)
    for here in range(rows * columns):  # roots come before what joined them
        if root[here] == here:
            flat[here] = n
            n += 1
        else:
            flat[here] = flat[root[here]]
    return n


@jit
def _bends(depth: F32, across: U8, along: U8) -> None:
    """Write 0 where a pixel and its neighbours in the row (``across``) and the column (``along``) lie on one plane."""
    rows, columns = depth.shape
    inverse = np.empty((rows, columns), np.float32)
    for v in range(rows):
        for u in range(columns):
            d = depth[v, u]
            inverse[v, u] = np.float32(1.0) / d if 0.0 < d < FAR_M else np.float32(0.0)
    for v in range(rows):
        for u in range(1, columns - 1):
            at = inverse[v, u]
            across[v, u] = abs(inverse[v, u - 1] + inverse[v, u + 1] - 2 * at) > PLANE_TOLERANCE * at
    for v in range(1, rows - 1):
        for u in range(columns):
            at = inverse[v, u]
            along[v, u] = abs(inverse[v - 1, u] + inverse[v + 1, u] - 2 * at) > PLANE_TOLERANCE * at


@merged
def _join(root: I32, a: int, b: int) -> None:
    """Join the sets of two elements; the smaller root stays."""
    while root[a] != a:
        root[a] = root[root[a]]
        a = root[a]
    while root[b] != b:
        root[b] = root[root[b]]
        b = root[b]
    if a < b:
        root[b] = a
    elif b < a:
        root[a] = b


@jit
def segment(
    depth: F32, boxes: I32, masks: Flags, size_m: F64, camera: F64, owner: I16, extent: F64, count: I32
) -> None:
    """Find the pixels of the thing in each box; boxes later in the order take pixels from earlier ones.

    A plane that goes on beyond a box (floor, wall, table top) is not the thing in it. Of the rest, what is about as
    deep as the box's main depth belongs to the thing.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        boxes: (n, 4) int32, pixels within the frame, from the largest to the smallest.
        masks: (n, H, W) bool, or (0, 0, 0) for a detector without masks.
        size_m: (n,) float64, largest plausible diagonal of the thing.
        camera: (8,) float64.
        owner: (H, W) int16, written: number of the box that a pixel belongs to; other pixels are left as they are.
        extent: (n, 6) float64, written: x0 y0 z0 x1 y1 z1 of the thing's points in metres.
        count: (n,) int32, written: the thing's pixels, including those that smaller boxes take.
    """
    rows, columns = depth.shape
    masked = masks.shape[0] > 0
    plane = np.zeros((rows, columns), np.int32)
    n = 0 if masked or boxes.shape[0] == 0 else planes(depth, plane)
    total, inside, behind = np.zeros(n, np.int32), np.zeros(n, np.int32), np.zeros(n, np.bool_)
    if n > 0:
        for v in range(rows):
            for u in range(columns):
                total[plane[v, u]] += 1
    for k in range(boxes.shape[0] - 1, -1, -1):
        box = boxes[k]
        mask = masks[k if masked else 0 : k + 1 if masked else 0]
        flat = mask.reshape(mask.shape[0] * mask.shape[1], mask.shape[2])
        if n > 0:
            _background(depth, box, plane, total, inside, behind)
        main = main_depth(depth, box, flat, plane, behind)
        # A thing is taken to be about as deep as it is wide; points farther off than that are something else.
        side_m = max(box[2] - box[0], box[3] - box[1]) * main / camera[7]
        reach = min(max(0.08, 0.6 * side_m), size_m[k])
        count[k] = _claim(depth, box, flat, plane, behind, k, (main, reach), camera, owner, extent[k])


@jit
def _background(depth: F32, box: I32, plane: I32, total: I32, inside: I32, behind: Flags) -> None:
    """Find the plane patches in a box that go on beyond it: floor, wall, table top.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        box: (4,) int32.
        plane: (H, W) int32, patch of every pixel.
        total: (n,) int32, pixels of every patch.
        inside: (n,) int32, scratch.
        behind: (n,) bool, written for the patches in the box. All False where little would be left of the box: then
            the thing is flush with what is beside it.
    """
    # The box may be off: what is a little beyond it may be the thing.
    grow = 1 + max(box[2] - box[0], box[3] - box[1]) // 8
    left, top = max(box[0] - grow, 0), max(box[1] - grow, 0)
    end, bottom = min(box[2] + grow, depth.shape[1]), min(box[3] + grow, depth.shape[0])
    for v in range(top, bottom):
        for u in range(left, end):
            inside[plane[v, u]] = 0
    for v in range(top, bottom):
        for u in range(left, end):
            inside[plane[v, u]] += 1
    dry, area = 0, 0
    for v in range(box[1], box[3]):
        for u in range(box[0], box[2]):
            patch = plane[v, u]
            behind[patch] = inside[patch] < MOSTLY * total[patch]
            if 0.0 < depth[v, u] < FAR_M:
                area += 1
                dry += not behind[patch]
    if dry < LEAST_LEFT * area:
        for v in range(box[1], box[3]):
            for u in range(box[0], box[2]):
                behind[plane[v, u]] = False


@jit
def _claim(
    depth: F32, box: I32, mask: Flags, plane: I32, behind: Flags, k: int, near: tuple[float, float], camera: F64,
    owner: I16, extent: F64,
) -> int:  # fmt: skip
    """Give the thing of box ``k`` its pixels, unless a smaller box has them, and write the extent (6,) of its own.

    Returns:
        How many pixels it has, with those of smaller boxes.
    """
    rows, columns = depth.shape
    main, reach = near
    masked = mask.shape[0] > 0
    on_floor = _mean_height(depth, box, main, camera) < 2 * FLOOR_M
    count = 0
    for steal in (False, True):  # what smaller boxes cover wholly is taken back
        count, own = 0, 0
        for v in range(box[1], box[3]):
            for u in range(box[0], box[2]):
                d = depth[v, u]
                if not 0.0 < d < FAR_M:
                    continue
                if masked:
                    if not mask[v, u]:
                        continue
                elif behind[plane[v, u]] or abs(d - main) > reach:
                    continue
                x, y, z = _point(u, v, d, rows, columns, camera)
                if z < FLOOR_M and not (on_floor or masked):
                    continue
                count += 1
                if owner[v, u] >= 0 and not steal:
                    continue
                owner[v, u] = k
                own += 1
                extent[0], extent[3] = min(extent[0], x), max(extent[3], x)
                extent[1], extent[4] = min(extent[1], y), max(extent[4], y)
                extent[2], extent[5] = min(extent[2], z), max(extent[5], z)
        if own > 0 or count == 0:
            break
    return count


@jit
def _mean_height(depth: F32, box: I32, main: float, camera: F64) -> float:
    """Mean height in metres of the points in a box that lie at its main depth, within 8 %."""
    rows, columns = depth.shape
    total, n = 0.0, 0
    for v in range(box[1], box[3]):
        for u in range(box[0], box[2]):
            d = depth[v, u]
            if abs(d - main) <= 0.08 * main:
                total += _point(u, v, d, rows, columns, camera)[2]
                n += 1
    return total / n if n else 0.0


@jit
def structure(depth: F32, camera: F64, half: int, upright: U8, image: I16) -> None:
    """Classify the pixels that belong to no thing as floor, wall, ceiling or obstacle.

    A pixel is a wall if it lies on an upright plane along an axis, at a cell border where such a plane was seen above
    all furniture, in this frame or an earlier one. Only every second row and column is classified: the map's cells are
    made from these.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        half: cell number of the start.
        upright: (2, n, n) uint8, updated: cell borders with a plane above all furniture; axes as the map's ``walls``.
        image: (H, W) int16, track of every pixel; entries of -1 with depth are set to 0 to 3.
    """
    rows, columns = depth.shape
    for marking in (True, False):
        for v in range(0, rows, 2):
            for u in range(0, columns, 2):
                d = depth[v, u]
                if image[v, u] >= 0 or not 0.0 < d < FAR_M:
                    continue
                z = _point(u, v, d, rows, columns, camera)[2]
                if marking:
                    if z > ABOVE_FURNITURE_M:
                        _border(depth, u, v, camera, half, upright, True)
                elif z < FLOOR_M:
                    image[v, u] = FLOORS
                elif z > CEILING_M:
                    image[v, u] = CEILINGS
                else:
                    image[v, u] = WALLS if _border(depth, u, v, camera, half, upright, False) else OBSTACLES


@jit
def _border(depth: F32, u: int, v: int, camera: F64, half: int, upright: U8, mark: bool) -> bool:
    """Whether a pixel lies on an upright plane at a marked cell border; with ``mark`` the border is marked first."""
    rows, columns = depth.shape
    a, b = (u + 1 if u + 1 < columns else u - 1), (v + 1 if v + 1 < rows else v - 1)
    x, y, z = _point(u, v, depth[v, u], rows, columns, camera)
    x1, y1, z1 = _point(a, v, depth[v, a], rows, columns, camera)
    x2, y2, z2 = _point(u, b, depth[b, u], rows, columns, camera)
    x1, y1, z1, x2, y2, z2 = x1 - x, y1 - y, z1 - z, x2 - x, y2 - y, z2 - z
    nx, ny, nz = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    if length == 0.0 or abs(nz) > 0.15 * length or max(abs(nx), abs(ny)) < 0.97 * length:
        return False
    axis = 0 if abs(nx) > abs(ny) else 1
    across, along = (x, y) if axis == 0 else (y, x)
    border = int(np.floor(across / CELL_M))
    if abs(across - (border + 0.5) * CELL_M) > 0.08:
        return False
    cell = int(np.floor(along / CELL_M + 0.5)) + half
    i, j = (border + half, cell) if axis == 0 else (cell, border + half)
    if not (0 <= i < upright.shape[1] and 0 <= j < upright.shape[2]):
        return False
    if mark:
        upright[axis, i, j] = 1
    return upright[axis, i, j] == 1


@jit
def associate(
    extent: F64, count: I32, label: I32, most_m: F64, boxes: F64, labels: I32, gate_m: float, track: I16
) -> None:
    """Give the boxes of a frame to the tracks that they fit best, the best pair first; a track takes one box.

    Args:
        extent: (n, 6) float64, 3-D boxes of the frame, metres.
        count: (n,) int32, pixels; boxes without any join no track.
        label: (n,) int32, number of each box's name.
        most_m: (n,) float64, longest plausible diagonal of a thing of that name.
        boxes: (T, 6) float64, 3-D boxes of the tracks, updated.
        labels: (T,) int32, numbers of their names.
        gate_m: largest gap.
        track: (n,) int16, written: the track, -1 for none.
    """
    n, n_tracks = extent.shape[0], boxes.shape[0]
    cost, taken = np.full((n_tracks, n), np.inf), np.zeros(n_tracks, np.bool_)
    track[:] = -1
    for old in range(n_tracks):
        for k in range(n):
            if count[k] > 0 and labels[old] == label[k]:
                cost[old, k] = _misfit(boxes[old], extent[k], most_m[k], gate_m)
    for _ in range(n):
        best, lowest = (-1, -1), np.inf
        for old in range(n_tracks):
            for k in range(n):
                if cost[old, k] < lowest and track[k] < 0 and not taken[old]:
                    best, lowest = (old, k), cost[old, k]
        if best[0] < 0:
            break
        track[best[1]], taken[best[0]] = best[0], True
    for k in range(n):
        if track[k] >= 0:
            for axis in range(3):
                boxes[track[k], axis] = min(boxes[track[k], axis], extent[k, axis])
                boxes[track[k], 3 + axis] = max(boxes[track[k], 3 + axis], extent[k, 3 + axis])


@jit
def _misfit(old: F64, new: F64, most_m: float, gate_m: float) -> float:
    """How badly a 3-D box (6,) fits a track's; infinite where together they are too large or too far apart."""
    gap, between, whole, a, b = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        apart = max(old[axis] - new[3 + axis], new[axis] - old[3 + axis], 0.0)
        middle = 0.5 * (old[axis] + old[3 + axis] - new[axis] - new[3 + axis])
        side = max(old[3 + axis], new[3 + axis]) - min(old[axis], new[axis])
        gap, between, whole = gap + apart * apart, between + middle * middle, whole + side * side
        a, b = a + (old[3 + axis] - old[axis]) ** 2, b + (new[3 + axis] - new[axis]) ** 2
    # A box that is too large already, by a poor detection or a wrong name, may still join its own track.
    if np.sqrt(gap) > gate_m or np.sqrt(whole) > max(most_m, np.sqrt(a), 1.15 * np.sqrt(b)):
        return np.inf
    return np.sqrt(gap) + 0.1 * np.sqrt(between)


@jit
def overlaps(image: I16, instance: I16, row: I32, pixels: I32) -> None:
    """Count the pixels that tracks and the simulator's instances share.

    Args:
        image: (H, W) int16, track of every pixel, -1 for none.
        instance: (H, W) int16, instance of every pixel, -1 for none.
        row: (most track + 2,) int32, row of each track in ``pixels``, -1 for tracks that are not counted.
        pixels: (m, n + 1) int32, updated; column 0 is for pixels of no instance.
    """
    for v in range(image.shape[0]):
        for u in range(image.shape[1]):
            track = image[v, u]
            if 0 <= track < row.shape[0] and row[track] >= 0:
                pixels[row[track], instance[v, u] + 1] += 1
