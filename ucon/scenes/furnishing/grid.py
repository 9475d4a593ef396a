"""Kernels of furnishing: which poses are allowed, and which nodes can be reached."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import jit

TOUCH_M = 0.002
FLAT_M = 0.02
"""Things lower than this, metres, can be walked and stood on: carpets."""


@jit
def turn_box(box: NDArray[np.float64], x: float, y: float, quarter_turns: int, out: NDArray[np.float64]) -> None:
    """Turn a box about the origin and move it.

    Args:
        box: (6,) metres.
        x: shift, metres.
        y: shift.
        quarter_turns: counter-clockwise.
        out: (6,) float64, written.
    """
    q = quarter_turns % 4
    if q == 0:
        out[0], out[1], out[3], out[4] = box[0], box[1], box[3], box[4]
    elif q == 1:
        out[0], out[1], out[3], out[4] = -box[4], box[0], -box[1], box[3]
    elif q == 2:
        out[0], out[1], out[3], out[4] = -box[3], -box[4], -box[0], -box[1]
    else:
        out[0], out[1], out[3], out[4] = box[1], -box[3], box[4], -box[0]
    out[0] += x
    out[3] += x
    out[1] += y
    out[4] += y
    out[2], out[5] = box[2], box[5]


@jit
def turned(boxes: NDArray[np.float64], x: float, y: float, quarter_turns: int) -> NDArray[np.float64]:
    """Boxes (n, 6) turned about the origin and moved.

    Args:
        boxes: (n, 6) metres.
        x: shift, metres.
        y: shift.
        quarter_turns: counter-clockwise.
    """
    out = np.empty_like(boxes)
    for k in range(len(boxes)):
        turn_box(boxes[k], x, y, quarter_turns, out[k])
    return out


@jit
def _overlap(a: NDArray[np.float64], b: NDArray[np.float64], axes: int) -> bool:
    for k in range(axes):  # noqa: SIM110 (numba compiles no generator)
        if min(a[3 + k], b[3 + k]) - max(a[k], b[k]) <= TOUCH_M:
            return False
    return True


@jit
def _outside(box: NDArray[np.float64], inner: NDArray[np.float64], height_m: float, slack_m: float) -> bool:
    return (
        box[0] < inner[0] - slack_m
        or box[1] < inner[1] - slack_m
        or box[3] > inner[2] + slack_m
        or box[4] > inner[3] + slack_m
        or box[5] > height_m + 1e-6
    )


@jit
def _hits_any(box: NDArray[np.float64], solids: NDArray[np.float64], as_void: bool) -> bool:
    flat = not as_void and box[5] <= FLAT_M
    for k in range(len(solids)):
        other_flat = solids[k, 5] <= FLAT_M
        if flat != other_flat:
            continue
        if _overlap(box, solids[k], 2 if flat else 3):
            return True
    return False


@jit
def allowed(
    poses: NDArray[np.float64],
    local: NDArray[np.float64],
    local_voids: NDArray[np.float64],
    solids: NDArray[np.float64],
    voids: NDArray[np.float64],
    inner: NDArray[np.float64],
    height_m: float,
) -> NDArray[np.bool_]:
    """Which poses of a group are allowed.

    Boxes of pieces must be inside ``inner`` and meet neither ``solids`` nor ``voids``; clear spaces must meet no
    ``solids``. Flat things may lie under everything but other flat things.

    Args:
        poses: (n, 3) x, y in metres, quarter turns.
        local: (p, 6) boxes of the pieces in the group's frame.
        local_voids: (q, 6) clear spaces in the group's frame.
        solids: (s, 6) boxes in the room.
        voids: (v, 6) spaces in the room that must stay clear.
        inner: (4,) free floor x0, y0, x1, y1.
        height_m: of the room.

    Returns:
        (n,) bool.
    """
    out = np.zeros(len(poses), np.bool_)
    box = np.empty(6)
    for n in range(len(poses)):
        x, y, q = poses[n, 0], poses[n, 1], int(poses[n, 2])
        good = True
        for m in range(len(local)):
            turn_box(local[m], x, y, q, box)
            if _outside(box, inner, height_m, 1e-5) or _hits_any(box, solids, False):
                good = False
                break
            if box[5] > FLAT_M:
                for k in range(len(voids)):
                    if _overlap(box, voids[k], 3):
                        good = False
                        break
            if not good:
                break
        if good:
            for m in range(len(local_voids)):
                turn_box(local_voids[m], x, y, q, box)
                if _outside(box, inner, 1e9, 0.051) or _hits_any(box, solids, True):
                    good = False
                    break
        out[n] = good
    return out


@jit
def flood(free: NDArray[np.bool_], i: int, j: int) -> NDArray[np.bool_]:
    """Cells connected to (i, j) over 4 neighbours.

    Args:
        free: (nx, ny) bool.
        i: start.
        j: start.

    Returns:
        (nx, ny) bool.
    """
    nx, ny = free.shape
    seen = np.zeros((nx, ny), np.bool_)
    if not free[i, j]:
        return seen
    stack = np.empty((nx * ny, 2), np.int32)
    stack[0, 0], stack[0, 1] = i, j
    seen[i, j] = True
    top = 1
    while top:
        top -= 1
        a, b = stack[top, 0], stack[top, 1]
        for k in range(4):
            p = a + (k == 0) - (k == 1)
            q = b + (k == 2) - (k == 3)
            if 0 <= p < nx and 0 <= q < ny and free[p, q] and not seen[p, q]:
                seen[p, q] = True
                stack[top, 0], stack[top, 1] = p, q
                top += 1
    return seen
