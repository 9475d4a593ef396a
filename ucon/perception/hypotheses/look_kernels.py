"""Kernel that finds which looks at things are new: looks from one side and distance make the same error."""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I32, U8, jit, merged

#: States of a (track, key): never looked at, looked at in vain, found.
NEVER, MISSED, FOUND = 0, 1, 2
#: Number of distances that are distinguished.
MOST_OCTAVES = 8
#: A thing is in view if its middle is in the image and nothing that is nearer by more than this hides it, metres.
HIDDEN_M = 0.15


@merged
def look_key(dx: float, dy: float, dz: float, sides: int, limits_m2: F64) -> int:
    """Number of the side and distance from which a thing is seen; looks with one number err together.

    Args:
        dx: from the camera to the thing along x, metres.
        dy: the same along y.
        dz: the same upwards.
        sides: how many sides are distinguished; eight need no trigonometry.
        limits_m2: (MOST_OCTAVES - 1,) squares of the distances at which a new octave begins, ascending.
    """
    if sides == 8:
        if dy >= 0.0:
            side = (0 if dy < dx else 1) if dx > 0.0 else (2 if -dx < dy else 3)
        else:
            side = (4 if -dy < -dx else 5) if dx < 0.0 else (6 if dx < -dy else 7)
    else:
        side = int(np.floor(np.arctan2(dy, dx) / (2.0 * np.pi / sides))) % sides
    away_m2, step = dx * dx + dy * dy + dz * dz, 0
    while step < limits_m2.shape[0] and away_m2 >= limits_m2[step]:
        step += 1
    return side * MOST_OCTAVES + step


@jit
def new_looks(
    box: F64, kind: U8, named: U8, depth: F32, camera: F64, sides: int, limits_m2: F64, reach_m: float, state: U8,
    event: I32, away_m: F64,
) -> int:  # fmt: skip
    """Looks of one frame from sides and distances from which a thing was not seen before.

    Args:
        box: (T, 6) float64, 3-D boxes of the tracks, metres.
        kind: (T,) uint8, 0 for things.
        named: (T,) uint8, 1 for tracks that the detector found in this frame.
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        sides: how many sides are distinguished; looks from one side and one interval of distances err together.
        limits_m2: (MOST_OCTAVES - 1,) squares of the limits of these intervals, ascending.
        reach_m: things farther away are not expected to be found, metres.
        state: (T, sides * MOST_OCTAVES) uint8, updated: ``NEVER``, ``MISSED`` or ``FOUND``.
        event: (T, 3) int32, written: track, key and ``MISSED`` or ``FOUND`` of the new looks.
        away_m: (T,) float64, written: their distances, metres.

    Returns:
        How many new looks there are; as many rows are written, ordered by track.
    """
    rows, columns = depth.shape
    x, y, z, c, s, cp, sp, focal_px = camera
    n = 0
    for track in range(box.shape[0]):
        if kind[track] != 0 or box[track, 3] < box[track, 0]:
            continue
        dx, dy = 0.5 * (box[track, 0] + box[track, 3]) - x, 0.5 * (box[track, 1] + box[track, 4]) - y
        dz = 0.5 * (box[track, 2] + box[track, 5]) - z
        away = np.sqrt(dx * dx + dy * dy + dz * dz)
        key = look_key(dx, dy, dz, sides, limits_m2)
        if named[track] != 0:
            if state[track, key] == FOUND:
                continue
            state[track, key] = FOUND
        else:
            if state[track, key] != NEVER or away > reach_m:
                continue
            ahead, right = c * dx + s * dy, s * dx - c * dy
            optical, up = cp * ahead + sp * dz, cp * dz - sp * ahead
            if optical < 0.2:
                continue
            u, v = int(0.5 * columns + focal_px * right / optical), int(0.5 * rows - focal_px * up / optical)
            if not (2 <= u < columns - 2 and 2 <= v < rows - 2):
                continue
            half = 0.0
            for axis in range(3):
                half = max(half, 0.5 * (box[track, 3 + axis] - box[track, axis]))
            if depth[v, u] < optical - half - HIDDEN_M:
                continue
            state[track, key] = MISSED
        event[n, 0], event[n, 1], event[n, 2], away_m[n] = track, key, state[track, key], away
        n += 1
    return n
