"""Kernels that value views: how much of the expected mass a pose would show, and what Open would open from there.

A view is (node, heading, pitch -60, -30, 0 or 30); there are H headings, four or six. Sight lines are tested against
the height map and the walls.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.compass import DIRECTIONS, TAN_HALF
from ucon.core.jit import F32, F64, I32, U8, jit, merged
from ucon.perception.mapping.map_kernels import CELL_M, shows

#: Pitches of views in degrees, up positive.
PITCHES_DEG = (-60, -30, 0, 30)
_COS = np.cos(np.deg2rad(PITCHES_DEG))
_SIN = np.sin(np.deg2rad(PITCHES_DEG))
#: For each node up to SPAN cells from a point, one bit says whether the point is hidden from there; a point has WORDS
#: words of 64 bits.
SPAN = 24
WORDS = ((2 * SPAN + 1) ** 2 + 63) // 64


@jit
def sight(x: float, y: float, cam_z: float, px: float, py: float, pz: float, height: F32, walls: U8, half: int) -> bool:
    """Whether nothing known stands between a camera and a point.

    Walls block at any height. Things block up to their height in the height map, except within 0.36 m of the point.

    Args:
        x: of the camera, metres.
        y: of the camera, metres.
        cam_z: of the camera, metres.
        px: of the point, metres.
        py: of the point, metres.
        pz: of the point, metres.
        height: (n, n) float32, metres.
        walls: (2, n, n) uint8.
        half: cell number of the start.
    """
    dx, dy = px - x, py - y
    length = np.sqrt(dx * dx + dy * dy)
    n = int(np.ceil(length / 0.2))
    open_part = 1.0 - 0.36 / max(length, 0.36)
    li, lj = int(np.floor(x / CELL_M + 0.5)) + half, int(np.floor(y / CELL_M + 0.5)) + half
    for k in range(1, n + 1):
        t = min(k * 0.2 / length, 1.0)
        i, j = int(np.floor((x + t * dx) / CELL_M + 0.5)) + half, int(np.floor((y + t * dy) / CELL_M + 0.5)) + half
        if (i != li or j != lj) and _walled(li, lj, i, j, walls):
            return False
        li, lj = i, j
        if t <= open_part and height[i, j] > cam_z + t * (pz - cam_z) + 0.02:
            return False
    return True


@merged
def _walled(i0: int, j0: int, i1: int, j1: int, walls: U8) -> bool:
    """Whether a wall stands between two neighbouring cells; for diagonal neighbours two borders must be closed."""
    i, j = min(i0, i1), min(j0, j1)
    if j0 == j1:
        return walls[0, i, j0] > 0
    if i0 == i1:
        return walls[1, i0, j] > 0
    return walls[0, i, j0] + walls[0, i, j1] + walls[1, i0, j] + walls[1, i1, j] > 1


@merged
def in_sight(
    m: int, i: int, j: int, cam_z: float, place: F64, hollow: F64, faces: U8, hidden: Any, height: F32, walls: U8,
    half: int,
) -> bool:  # fmt: skip
    """Whether a node sees a sample point, through an open side of its compartment and with nothing in between.

    Heights and walls only grow, so a point once hidden from a node stays hidden from it: ``hidden`` records this.

    Args:
        m: row of the point.
        i: of the node.
        j: of the node.
        cam_z: height of the camera, metres.
        place: (m, 3) float64, the points, metres.
        hollow: (m, 6) float64, boxes of their compartments, metres.
        faces: (m,) uint8, bits of the compartments' open sides.
        hidden: (m, WORDS) uint64, updated: bits of the nodes around each point from which it is hidden.
        height: (c, c) float32, metres.
        walls: (2, c, c) uint8.
        half: cell number of the start.
    """
    px, py, pz = place[m]
    a = i - half - int(np.floor(px / CELL_M + 0.5)) + SPAN
    b = j - half - int(np.floor(py / CELL_M + 0.5)) + SPAN
    kept = 0 <= a <= 2 * SPAN and 0 <= b <= 2 * SPAN
    word, bit = 0, np.uint64(0)
    if kept:
        number = a * (2 * SPAN + 1) + b
        word, bit = number >> 6, np.uint64(1) << np.uint64(number & 63)
        if hidden[m, word] & bit:
            return False
    x, y = (i - half) * CELL_M, (j - half) * CELL_M
    if shows(x, y, cam_z, px, py, pz, hollow[m], faces[m]) and sight(x, y, cam_z, px, py, pz, height, walls, half):
        return True
    if kept:
        hidden[m, word] |= bit
    return False


@merged
def between(nodes: I32, low: int, high: int) -> tuple[int, int]:
    """Rows, the last excluded, of the nodes with ``low`` <= i <= ``high``; the nodes (n, 2) are sorted by i."""
    first, last = 0, nodes.shape[0]
    while first < last:
        middle = (first + last) // 2
        if nodes[middle, 0] < low:
            first = middle + 1
        else:
            last = middle
    end, stop = first, nodes.shape[0]
    while end < stop:
        middle = (end + stop) // 2
        if nodes[middle, 0] <= high:
            end = middle + 1
        else:
            stop = middle
    return first, end


@jit
def place_gain(
    nodes: I32, rows: I32, place: F64, hollow: F64, faces: U8, weight: F64, hidden: Any, reach_m: float, cam_z: float,
    height: F32, walls: U8, half: int, out: F64,
) -> None:  # fmt: skip
    """Add the weight of the sample points that each view would show.

    A point in a compartment is shown through the open sides only.

    Args:
        nodes: (n, 2) int32, sorted by i.
        rows: (k,) int32, the points that count.
        place: (m, 3) float64, the points, metres.
        hollow: (m, 6) float64, boxes of their compartments, metres.
        faces: (m,) uint8, bits of the compartments' open sides.
        weight: (m,) float64.
        hidden: (m, WORDS) uint64, updated; see :func:`in_sight`.
        reach_m: greatest distance from which a point counts as shown, metres.
        cam_z: height of the camera, metres.
        height: (c, c) float32, metres.
        walls: (2, c, c) uint8.
        half: cell number of the start.
        out: (n, H, 4) float64, updated: node, heading, pitch.
    """
    span = int(reach_m / CELL_M) + 1
    for m in rows:
        w = weight[m]
        px, py, pz = place[m]
        middle = int(np.floor(px / CELL_M + 0.5)) + half
        first, last = between(nodes, middle - span, middle + span)
        for n in range(first, last):
            i, j = nodes[n]
            dx, dy, dz = px - (i - half) * CELL_M, py - (j - half) * CELL_M, pz - cam_z
            if dx * dx + dy * dy > reach_m * reach_m:
                continue
            if in_sight(m, i, j, cam_z, place, hollow, faces, hidden, height, walls, half):
                add_to_views(dx, dy, dz, w, reach_m, out[n])


@merged
def add_to_views(dx: float, dy: float, dz: float, w: float, reach_m: float, out: F64) -> None:
    """Add ``w`` to every view (heading, pitch) of ``out`` (H, 4) in which a point (dx, dy, dz) from the camera lies."""
    n = out.shape[0]
    for heading in range(n):
        for p in range(4):
            if in_view(dx, dy, dz, heading, n, p, reach_m):
                out[heading, p] += w


@merged
def in_view(dx: float, dy: float, dz: float, heading: int, n: int, p: int, reach_m: float) -> bool:
    """Whether a point (dx, dy, dz) from the camera lies in the view of heading ``heading`` of n and pitch number p.

    A margin of 5 % of the view's width is left out.
    """
    c, s, width = DIRECTIONS[n, heading, 0], DIRECTIONS[n, heading, 1], 0.95 * TAN_HALF[n]
    flat, side = c * dx + s * dy, abs(s * dx - c * dy)
    cp, sp = _COS[p], _SIN[p]
    optical, up = cp * flat + sp * dz, cp * dz - sp * flat
    return 0.15 < optical <= reach_m and side <= width * optical and abs(up) <= width * optical


@jit
def fade_places(
    x: float, y: float, cam_z: float, looks: tuple[int, int, int], place: F64, hollow: F64, faces: U8, weight: F64,
    reach_m: float, height: F32, walls: U8, half: int, unseen: F64, factor: float,
) -> None:  # fmt: skip
    """Multiply ``unseen`` of the points that a view was expected to show, whether or not its frame really showed them.

    Args:
        x: of the camera, metres.
        y: of the camera, metres.
        cam_z: of the camera, metres.
        looks: heading, number of headings, and number of the pitch in ``PITCHES_DEG``.
        place: (m, 3) float64, the points, metres.
        hollow: (m, 6) float64, boxes of their compartments, metres.
        faces: (m,) uint8, bits of the compartments' open sides.
        weight: (m,) float64; points of weight 0 are left alone.
        reach_m: greatest distance from which a point counts as shown, metres.
        height: (c, c) float32, metres.
        walls: (2, c, c) uint8.
        half: cell number of the start.
        unseen: (m,) float64, updated.
        factor: multiplies ``unseen``.
    """
    heading, n, pitch = looks
    for m in range(place.shape[0]):
        if weight[m] <= 0.0:
            continue
        px, py, pz = place[m]
        if not shows(x, y, cam_z, px, py, pz, hollow[m], faces[m]):
            continue
        if not sight(x, y, cam_z, px, py, pz, height, walls, half):
            continue
        if in_view(px - x, py - y, pz - cam_z, heading, n, pitch, reach_m):
            unseen[m] *= factor


@jit
def open_gain(
    index: I32, boxes: F64, whole: bool, weight: F64, reach_m: float, cam_z: float, height: F32, walls: U8, half: int,
    out: F64,
) -> None:  # fmt: skip
    """Add the weight of the closed containers that Open would open from each view.

    Args:
        index: (c, c) int32, row of a node in ``out``, -1 where no view is considered.
        boxes: (m, 6) float64, what was seen of the containers, metres.
        whole: whether boxes are whole containers, which hide their own middle: their nearest point must be in sight.
            Otherwise boxes are fronts, whose middle must be in sight.
        weight: (m,) float64, mass inside.
        reach_m: reach of Open, metres.
        cam_z: height of the camera, metres.
        height: (c, c) float32, metres.
        walls: (2, c, c) uint8.
        half: cell number of the start.
        out: (n, H, 4) float64, updated: node, heading, pitch.
    """
    span = int(reach_m / CELL_M) + 1
    for m in range(boxes.shape[0]):
        w = weight[m]
        if w <= 0.0:
            continue
        x0, y0, z0, x1, y1, z1 = boxes[m]
        i0, i1 = int(np.floor(x0 / CELL_M)) + half - span, int(np.floor(x1 / CELL_M)) + half + span + 2
        j0, j1 = int(np.floor(y0 / CELL_M)) + half - span, int(np.floor(y1 / CELL_M)) + half + span + 2
        for i in range(max(1, i0), min(index.shape[0] - 1, i1)):
            for j in range(max(1, j0), min(index.shape[0] - 1, j1)):
                n = index[i, j]
                if n < 0:
                    continue
                x, y = (i - half) * CELL_M, (j - half) * CELL_M
                gx, gy = max(x0 - x, x - x1, 0.0), max(y0 - y, y - y1, 0.0)
                if gx * gx + gy * gy > reach_m * reach_m:
                    continue
                px, py = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
                pz = min(max(cam_z - 0.2, z0), z1)
                sx, sy = (min(max(x, x0), x1), min(max(y, y0), y1)) if whole else (px, py)
                if sight(x, y, cam_z, sx, sy, pz, height, walls, half):
                    add_to_views(px - x, py - y, pz - cam_z, w, 4.0, out[n])
