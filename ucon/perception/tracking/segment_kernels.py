"""Kernels that find the pixels of the thing in a box.

The camera is that of :mod:`ucon.perception.mapping.map_kernels`; heights are metres above the floor.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, Flags, jit
from ucon.perception.mapping.map_kernels import FAR_M, point
from ucon.perception.tracking.plane_kernels import planes

#: Points below this height are floor, metres.
FLOOR_M = 0.05
#: The depth histogram: bins of 5 % each, from 0.1 m on.
_STEP, _NEAREST_M, _BINS = np.log(1.05), 0.1, 140
#: A plane patch belongs to what is behind a box if less than this share of it lies in the box, unless less than
#: LEAST_LEFT of the box would be left.
MOSTLY, LEAST_LEFT = 0.9, 0.15


@jit
def main_depth(depth: F32, box: I32, mask: Flags, plane: I32, behind: Flags) -> float:
    """The most common depth in a box, in metres; 0 if the box shows nothing.

    Only the inner half of the box counts, or all of it where the inner half shows nothing.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        box: (4,) int32, pixels within the frame; right and bottom exclusive.
        mask: (H, W) bool, the thing's pixels; (0, 0) for a detector without masks.
        plane: (H, W) int32, plane patch of every pixel.
        behind: (n,) bool, patches that extend beyond the box: they are left out. Not read with a mask.
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
def segment(
    depth: F32, boxes: I32, masks: Flags, size_m: F64, camera: F64, owner: I16, extent: F64, count: I32
) -> None:
    """Find the pixels of the thing in each box; boxes later in the order take pixels from earlier ones.

    A plane that extends beyond a box (floor, wall, table top) is not the thing in it. Of the rest, pixels near the
    box's main depth belong to the thing.

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
    """Find the plane patches in a box that extend beyond it: floor, wall, table top.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        box: (4,) int32.
        plane: (H, W) int32, patch of every pixel.
        total: (n,) int32, pixels of every patch.
        inside: (n,) int32, scratch.
        behind: (n,) bool, written for the patches in the box. All False where little would be left of the box: then
            the thing is flush with what is next to it.
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
    for steal in (False, True):  # a thing that smaller boxes cover wholly takes its pixels back
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
                x, y, z = point(u, v, d, rows, columns, camera)
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
                total += point(u, v, d, rows, columns, camera)[2]
                n += 1
    return total / n if n else 0.0
