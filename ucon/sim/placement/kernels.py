"""Kernels of placement."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import jit

Array = NDArray[np.float64]


@jit
def rows_meeting(boxes: Array, box: Array) -> NDArray[np.int64]:
    """Rows of boxes that meet a box.

    Args:
        boxes: (m, 6) metres.
        box: (6,) metres.

    Returns:
        (k,) int64.
    """
    found = np.empty(len(boxes), np.int64)
    count = 0
    for k in range(len(boxes)):
        b = boxes[k]
        if b[0] < box[3] and b[3] > box[0] and b[1] < box[4] and b[4] > box[1] and b[2] < box[5] and b[5] > box[2]:
            found[count] = k
            count += 1
    return found[:count].copy()


@jit
def are_clear(parts: Array, boxes: Array, touch: float) -> NDArray[np.bool_]:
    """Whether boxes meet none of some parts.

    Args:
        parts: (m, 6) metres.
        boxes: (n, 6) metres; each is shrunk by ``touch`` on every side before the test.
        touch: metres.

    Returns:
        (n,) bool.
    """
    result = np.ones(len(boxes), np.bool_)
    for i in range(len(boxes)):
        b = boxes[i]
        for k in range(len(parts)):
            p = parts[k]
            if (
                p[0] < b[3] - touch
                and p[3] > b[0] + touch
                and p[1] < b[4] - touch
                and p[4] > b[1] + touch
                and p[2] < b[5] - touch
                and p[5] > b[2] + touch
            ):
                result[i] = False
                break
    return result


@jit
def rug_tops(parts: Array, boxes: Array, most: float) -> Array:
    """The flat things under some boxes.

    Args:
        parts: (m, 6) metres.
        boxes: (n, 6) metres.
        most: only parts whose top is below this height count.

    Returns:
        (n, 2): top of the highest such part, and 1 if the box is only partly on it.
    """
    result = np.zeros((len(boxes), 2))
    for k in range(len(parts)):
        p = parts[k]
        if p[5] > most or p[5] <= 0.0:
            continue
        for i in range(len(boxes)):
            b = boxes[i]
            if p[0] < b[3] and p[3] > b[0] and p[1] < b[4] and p[4] > b[1]:
                result[i, 0] = max(result[i, 0], p[5])
                if p[0] > b[0] or p[3] < b[3] or p[1] > b[1] or p[4] < b[4]:
                    result[i, 1] = 1.0
    return result


@jit
def node_distances(free: NDArray[np.bool_], ox: float, oy: float, step: float, xy: Array, reach: int) -> Array:
    """Distance from points to the nearest free node.

    Args:
        free: (nx, ny) bool.
        ox: x of the corner of cell (0, 0), metres.
        oy: y of it.
        step: side of a cell, metres.
        xy: (n, 2) points, metres.
        reach: cells searched; greater distances are cut off there.

    Returns:
        (n,) metres.
    """
    nx, ny = free.shape
    result = np.full(len(xy), reach * step)
    for k in range(len(xy)):
        ci, cj = math.floor((xy[k, 0] - ox) / step), math.floor((xy[k, 1] - oy) / step)
        for i in range(max(ci - reach, 0), min(ci + reach + 1, nx)):
            for j in range(max(cj - reach, 0), min(cj + reach + 1, ny)):
                if free[i, j]:
                    dx, dy = ox + (i + 0.5) * step - xy[k, 0], oy + (j + 0.5) * step - xy[k, 1]
                    result[k] = min(result[k], math.sqrt(dx * dx + dy * dy))
    return result


@jit
def ring(box: Array, half_x: float, half_y: float, gaps: Array, step: float, most: int) -> Array:
    """Footprint centres all around a box at given gaps, corners included.

    Args:
        box: (6,) metres.
        half_x: half the footprint's extent along x.
        half_y: half the footprint's extent along y.
        gaps: (g,) metres.
        step: distance between centres, metres.
        most: most steps per side.

    Returns:
        (n, 2) metres.
    """
    points = np.empty((len(gaps) * 4 * (most + 1), 2))
    count = 0
    for gap in gaps:
        x0, x1 = box[0] - gap - half_x, box[3] + gap + half_x
        y0, y1 = box[1] - gap - half_y, box[4] + gap + half_y
        nx = min(max(int((x1 - x0) / step), 2), most)
        ny = min(max(int((y1 - y0) / step), 2), most)
        for k in range(nx + 1):
            x = x0 + (x1 - x0) * k / nx
            points[count, 0], points[count, 1] = x, y0
            points[count + 1, 0], points[count + 1, 1] = x, y1
            count += 2
        for k in range(1, ny):
            y = y0 + (y1 - y0) * k / ny
            points[count, 0], points[count, 1] = x0, y
            points[count + 1, 0], points[count + 1, 1] = x1, y
            count += 2
    return points[:count].copy()
