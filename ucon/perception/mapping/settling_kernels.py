"""Kernels that keep what single looks showed of things, and find the box on which most of them agree."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, U8, Flags, jit, merged
from ucon.perception.hypotheses.look_kernels import look_key
from ucon.perception.mapping.map_kernels import FAR_M, point

#: Shares of the looks that are left out at every side, in order, until the box is no larger than things of its name.
SHARES = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.49])

#: Two boxes are of one thing if they have the same name and share more than this part of the smaller one's volume, or
#: different names and an intersection over union above this. In no home of ours do things overlap that much.
SAME_NAME, ANY_NAME = 0.2, 0.3
#: Sides of boxes count as at least this many metres.
_THIN_M = 0.02


@jit
def extents(depth: F32, image: I16, camera: F64, extent: F64, pixels: I32) -> None:
    """Boxes around what one frame shows of each track.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        image: (H, W) int16, track of every pixel, -1 for none.
        camera: (8,) float64.
        extent: (T, 6) float64, written: x0 y0 z0 x1 y1 z1, metres; x0 > x1 where nothing is seen.
        pixels: (T,) int32, written.
    """
    rows, columns = depth.shape
    pixels[:] = 0
    extent[:, :3], extent[:, 3:] = 1e3, -1e3
    for v in range(rows):
        for u in range(columns):
            t, d = image[v, u], depth[v, u]
            if not 0 <= t < pixels.shape[0] or not 0.0 < d < FAR_M:
                continue
            xyz = point(u, v, d, rows, columns, camera)
            pixels[t] += 1
            for axis in range(3):
                extent[t, axis] = min(extent[t, axis], xyz[axis])
                extent[t, 3 + axis] = max(extent[t, 3 + axis], xyz[axis])


@jit
def note(
    extent: F64, pixels: I32, called: I32, frozen: Flags, camera: F64, sides: int, limits_m2: F64, most: I32,
    names: I16, boxes: F32,
) -> None:  # fmt: skip
    """Keep, for every side and distance, the look that showed most of a thing.

    Args:
        extent: (T, 6) float64, what one frame shows of each track, metres.
        pixels: (T,) int32, in that frame.
        called: (T,) int32, row of the name that the detector gives it there, -1 where it gives none.
        frozen: (T,) bool, tracks that were opened: their doors swing.
        camera: (8,) float64.
        sides: how many sides are distinguished; looks from one side and one interval of distances err together.
        limits_m2: (MOST_OCTAVES - 1,) squares of the limits of these intervals, ascending.
        most: (T, K) int32, updated: most pixels from each side and distance.
        names: (T, K) int16, updated: row of the name in that frame.
        boxes: (T, K, 6) float32, updated: what it showed, metres.
    """
    for t in range(extent.shape[0]):
        if called[t] < 0 or frozen[t] or pixels[t] == 0:
            continue
        middle = 0.5 * (extent[t, :3] + extent[t, 3:])
        key = look_key(middle[0] - camera[0], middle[1] - camera[1], middle[2] - camera[2], sides, limits_m2)
        if pixels[t] >= most[t, key]:
            most[t, key], names[t, key] = pixels[t], called[t]
            boxes[t, key] = extent[t].astype(np.float32)


@jit
def settle(most: I32, names: I16, boxes: F32, name: I32, wide_m: F64, high_m: F64, box: F64, is_set: U8) -> None:
    """Find the boxes of things: around the looks that call them by their names, but no larger than such things are.

    At every side the outermost looks are left out, as many as it takes until the box is no wider and no higher than
    things of that name; few looks include something next to or behind a thing.

    Args:
        most: (T, K) int32, pixels of each look; 0 for none.
        names: (T, K) int16, row of the name in each look.
        boxes: (T, K, 6) float32, what it showed, metres.
        name: (T,) int32, row of each track's name; -1 for tracks that are left out.
        wide_m: (T,) float64, diagonal of the footprint of things of that name.
        high_m: (T,) float64, their height.
        box: (T, 6) float64, written for tracks of which there are looks.
        is_set: (T,) uint8, written: 1 for these.
    """
    low, high = np.empty((3, most.shape[1]), np.float32), np.empty((3, most.shape[1]), np.float32)
    for t in range(most.shape[0]):
        is_set[t] = 0
        if name[t] < 0:
            continue
        own = np.count_nonzero((most[t] > 0) & (names[t] == name[t])) > 0
        n = 0
        for key in range(most.shape[1]):
            if most[t, key] > 0 and (names[t, key] == name[t] or not own):
                low[:, n], high[:, n] = boxes[t, key, :3], boxes[t, key, 3:]
                n += 1
        if n == 0:
            continue
        is_set[t] = 1
        for axis in range(3):
            low[axis, :n].sort()
            high[axis, :n].sort()
        _agreed(low[:2, :n], high[:2, :n], wide_m[t], box[t, :2], box[t, 3:5])
        _agreed(low[2:, :n], high[2:, :n], high_m[t], box[t, 2:3], box[t, 5:])


@jit
def _agreed(low: F32, high: F32, most_m: float, first: F64, last: F64) -> None:
    """Write the ends (a,) of the box on which looks (a, n), ascending, agree; ``most_m`` limits its diagonal."""
    n = low.shape[1]
    for share in SHARES:
        out, whole = int(share * n), 0.0
        for axis in range(low.shape[0]):
            a, b = low[axis, out], high[axis, n - 1 - out]
            first[axis], last[axis] = min(a, b), max(a, b)
            whole += (b - a) * (b - a)
        if whole <= most_m * most_m:
            break


@jit
def unite(box: F64, name: I32, looks: F64, into: I32) -> None:
    """Find the tracks that are of one thing, and which of them stays.

    Args:
        box: (T, 6) float64, metres.
        name: (T,) int32, row of each track's name; -1 for tracks that are left out.
        looks: (T,) float64, how often each was found: of the tracks of a thing, the one found most often stays.
        into: (T,) int32, written: the track that stays; its own number for those that stay or are left out.
    """
    order, n = np.argsort(-looks, kind="mergesort"), 0
    stay = np.empty(len(name), np.int64)
    for k in range(len(name)):
        into[k] = k
    for t in order:
        if name[t] < 0:
            continue
        for k in range(n):
            if _is_one(box[t], box[stay[k]], name[t] == name[stay[k]]):
                into[t] = stay[k]
                break
        else:
            stay[n] = t
            n += 1


@merged
def _is_one(a: F64, b: F64, same_name: bool) -> bool:
    """Whether two boxes (6,) are of one thing."""
    common, one, other = 1.0, 1.0, 1.0
    for axis in range(3):
        common *= max(min(a[3 + axis], b[3 + axis]) - max(a[axis], b[axis]), 0.0)
        one *= max(a[3 + axis] - a[axis], _THIN_M)
        other *= max(b[3 + axis] - b[axis], _THIN_M)
    return common > SAME_NAME * min(one, other) if same_name else common > ANY_NAME * (one + other - common)
