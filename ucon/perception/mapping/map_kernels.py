"""Kernels of the semantic map: from depth to cells, 3-D boxes and explored space; which places a frame shows.

Cells are 0.25 m and centred on the nodes the agent can stand on: cell (i, j) holds x in (i - half ± 0.5) * 0.25.
A camera is the float64 array (x, y, z, cos yaw, sin yaw, cos pitch, sin pitch, focal length in pixels).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, U8, Flags, jit, merged

CELL_M = 0.25
#: All six sides of a compartment open; bits 0 to 5 are -x, +x, -y, +y, -z, +z.
ALL_OPEN = 63
#: Obstacles closer than this to a node make it impassable: the robot's radius, metres.
RADIUS_M = 0.18
#: Points below the first height are floor; points from there to the second block the way. Metres.
LOW_M, TALL_M = 0.05, 1.8
#: Points above this height are left out of the height map: what is under a lintel or a top cabinet can be seen.
LINTEL_M = 1.9
#: Depths from here on are background, metres.
FAR_M = 60.0
FLOORS, WALLS, CEILINGS = 1, 2, 3
#: Two sight lines pass the same cells if their steps differ by less than _ALIKE_M metres and all points of one of them
#: (64 at most) stay _CLEAR cells away from cell borders.
_ALIKE_M, _CLEAR = 1e-12, 1e-9


@merged
def point(u: int, v: int, d: float, rows: int, columns: int, camera: F64) -> tuple[float, float, float]:
    """The point that pixel (u, v) shows at depth ``d``: x, y, z in metres in the start frame."""
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    up = (0.5 * rows - v - 0.5) / focal_px
    f, right = d * (cp - sp * up), d * ((u + 0.5 - 0.5 * columns) / focal_px)
    return x + c * f + s * right, y + s * f - c * right, cam_z + d * (sp + cp * up)


@jit
def integrate(
    depth: F32, tracks: I16, camera: F64, half: int, cells: Any, kind: U8, frozen: Flags, box: F64, far_m: float
) -> None:
    """Add one frame to the cell maps and to the 3-D boxes of its tracks.

    Cells are updated from every second pixel. Boxes use every pixel, since a thing may have only four.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        tracks: (H, W) int16, track of every pixel, -1 for none.
        camera: (8,) float64.
        half: cell number of the start.
        cells: (height, near, floor, blocked, walls), the map's arrays, updated.
        kind: (T,) uint8, 0 for things, else the code of the structure.
        frozen: (T,) bool, tracks whose boxes must not change (opened ones: their doors swing).
        box: (T, 6) float64, updated: x0 y0 z0 x1 y1 z1 in metres.
        far_m: points at this depth or more are not entered into the cells, metres.
    """
    rows, columns = depth.shape
    point, cell, aside = np.empty((3, columns)), np.empty((2, columns), np.int32), np.empty(columns)
    for u in range(columns):
        aside[u] = (u + 0.5 - 0.5 * columns) / camera[7]
    for v in range(rows):
        # The arithmetic of a whole row comes first, so that the compiler can vectorise it.
        _project(depth[v], (0.5 * rows - v - 0.5) / camera[7], aside, camera, point)
        _widen(depth[v], tracks[v], point, kind, frozen, box)
        if v & 1 == 0:
            _cells(point, half, cell)
            _mark(depth[v], tracks[v], point, cell, half, cells, kind, frozen, far_m)


@jit
def _project(depth: F32, up: float, aside: F64, camera: F64, point: F64) -> None:
    """Write the points (3, W) that the pixels of a row show: x, y, z in metres."""
    x, y, cam_z, c, s, cp, sp, _ = camera
    ahead, rise = cp - sp * up, sp + cp * up
    for u in range(depth.shape[0]):
        d = depth[u]
        f, right = d * ahead, d * aside[u]
        point[0, u], point[1, u], point[2, u] = x + c * f + s * right, y + s * f - c * right, cam_z + d * rise


@jit
def _cells(point: F64, half: int, cell: I32) -> None:
    """Write the cells (2, W) that hold the points (3, W)."""
    for u in range(point.shape[1]):
        cell[0, u] = np.int32(np.floor(point[0, u] / CELL_M + 0.5)) + half
        cell[1, u] = np.int32(np.floor(point[1, u] / CELL_M + 0.5)) + half


@jit
def _widen(depth: F32, tracks: I16, point: F64, kind: U8, frozen: Flags, box: F64) -> None:
    """Extend the tracks' boxes by the points of a row, one run of equal tracks at a time."""
    u, columns = 0, depth.shape[0]
    while u < columns:
        t, first = tracks[u], u
        while u < columns and tracks[u] == t:
            u += 1
        if not 0 <= t < kind.shape[0] or kind[t] != 0 or frozen[t]:
            continue
        x0, y0, z0, x1, y1, z1 = box[t]
        for k in range(first, u):
            if 0.0 < depth[k] < FAR_M:
                x0, x1 = min(x0, point[0, k]), max(x1, point[0, k])
                y0, y1 = min(y0, point[1, k]), max(y1, point[1, k])
                z0, z1 = min(z0, point[2, k]), max(z1, point[2, k])
        box[t, 0], box[t, 1], box[t, 2], box[t, 3], box[t, 4], box[t, 5] = x0, y0, z0, x1, y1, z1


@jit
def _mark(
    depth: F32, tracks: I16, point: F64, cell: I32, half: int, cells: Any, kind: U8, frozen: Flags, far_m: float
) -> None:
    """Enter every second point of a row into the cell maps."""
    height, near, floor, blocked, walls = cells
    last = height.shape[0] - 1
    for u in range(0, depth.shape[0], 2):
        t, d, i, j = tracks[u], depth[u], cell[0, u], cell[1, u]
        if t < 0 or t >= kind.shape[0] or not (0.0 < d < far_m) or i < 1 or j < 1 or i >= last or j >= last:
            continue
        if d < near[i, j]:
            near[i, j] = d
        z = point[2, u]
        if kind[t] == CEILINGS:
            continue
        if z < LOW_M:
            floor[i, j] = 1
            continue
        if z < LINTEL_M and z > height[i, j]:
            height[i, j] = z
        if z < TALL_M and not frozen[t]:
            dx, dy = point[0, u] - (i - half) * CELL_M, point[1, u] - (j - half) * CELL_M
            _block(blocked, i, j, dx, dy)
            if kind[t] == WALLS:
                _wall(walls, i, j, dx, dy)


@merged
def _wall(walls: U8, i: int, j: int, dx: float, dy: float) -> None:
    """Mark the cell border that a wall point belongs to: walls stand on borders, their faces 5 cm to either side.

    Points near a corner of the cell could belong to either border and are left out. ``walls`` (2, n, n): border of
    (i, j) towards (i + 1, j), and towards (i, j + 1).
    """
    ax, ay = abs(dx), abs(dy)
    if ax > 0.06 and ay < 0.06:
        walls[0, i - (dx < 0.0), j] = 1
    elif ay > 0.06 and ax < 0.06:
        walls[1, i, j - (dy < 0.0)] = 1


@merged
def _block(blocked: U8, i: int, j: int, dx: float, dy: float) -> None:
    """Mark the nodes that an obstacle point makes impassable.

    (dx, dy) is the point in metres from node (i, j), in whose cell it lies; only that node and the three nearest others
    can be within the robot's radius. There are no branches: they would be mispredicted half the time.
    """
    a, b = i + (1 if dx > 0.0 else -1), j + (1 if dy > 0.0 else -1)
    ex, ey = CELL_M - abs(dx), CELL_M - abs(dy)
    blocked[i, j] = 1
    blocked[a, j] |= ex * ex + dy * dy < RADIUS_M * RADIUS_M
    blocked[i, b] |= dx * dx + ey * ey < RADIUS_M * RADIUS_M
    blocked[a, b] |= ex * ex + ey * ey < RADIUS_M * RADIUS_M


@jit
def nearest(depth: F32, tracks: I16, camera: F64, out: F32) -> None:
    """Horizontal distance from the camera to the nearest point of each track in a frame.

    Args:
        depth: (H, W) float32, metres along the optical axis, 0 where there is no reading.
        tracks: (H, W) int16, track of every pixel, -1 for none.
        camera: (8,) float64.
        out: (T,) float32, written, metres; infinite for tracks that are not in view.
    """
    rows, columns = depth.shape
    out[:] = np.inf
    for v in range(rows):
        ahead = camera[5] - camera[6] * (0.5 * rows - v - 0.5) / camera[7]
        for u in range(columns):
            t, d = tracks[v, u], depth[v, u]
            if 0 <= t < out.shape[0] and 0.0 < d < FAR_M:
                aside = (u + 0.5 - 0.5 * columns) / camera[7]
                out[t] = min(out[t], np.float32(d * np.sqrt(ahead * ahead + aside * aside)))


@jit
def carve(depth: F32, camera: F64, half: int, explored: U8, reach_m: float) -> int:
    """Mark the cells under the sight lines of a frame as explored.

    In a level picture all sight lines of one column lie over each other; only the longest of these is followed.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        half: cell number of the start.
        explored: (n, n) uint8, updated.
        reach_m: longest sight line over the floor, metres.

    Returns:
        How many cells became explored.
    """
    rows, columns = depth.shape
    fresh, way = 0, np.empty((rows // 8 + 1, 3))
    for u in range(0, columns, 2):
        aside = (u + 0.5 - 0.5 * columns) / camera[7]
        count, longest = 0, 0
        for v in range(4, rows, 8):
            ahead = camera[5] - camera[6] * (0.5 * rows - v - 0.5) / camera[7]
            if _way(depth[v, u], ahead, aside, camera, reach_m, way[count]):
                longest = count if way[count, 2] > way[longest, 2] else longest
                count += 1
        if count == 0:
            continue
        dx, dy = way[longest, 0], way[longest, 1]
        marked, clear = _trace(explored, half, camera[0], camera[1], dx, dy, int(way[longest, 2]))
        fresh += marked
        for k in range(count):
            along = clear > _CLEAR and abs(way[k, 0] - dx) < _ALIKE_M and abs(way[k, 1] - dy) < _ALIKE_M
            if k != longest and not along:
                marked, _ = _trace(explored, half, camera[0], camera[1], way[k, 0], way[k, 1], int(way[k, 2]))
                fresh += marked
    return fresh


@merged
def _way(d: float, ahead: float, aside: float, camera: F64, reach_m: float, way: F64) -> bool:
    """Write the sight line of a pixel as a step (dx, dy) over the floor in metres and the number of steps.

    Returns whether it is long enough to follow.
    """
    c, s, d = camera[3], camera[4], min(d, FAR_M)
    if not d > 0.0:
        return False
    f, right = d * ahead, d * aside
    hx, hy = c * f + s * right, s * f - c * right
    length = np.sqrt(hx * hx + hy * hy)
    if not length > 0.15:
        return False
    step = 0.125 / length
    way[0], way[1], way[2] = step * hx, step * hy, int(min(length - 0.02, reach_m) / 0.125)
    return True


@merged
def _trace(explored: U8, half: int, x: float, y: float, dx: float, dy: float, n: int) -> tuple[int, float]:
    """Mark the cells of n steps from a point.

    Returns how many cells became explored, and how far (in cells) all steps stay from cell borders.
    """
    fresh, off = 0, 0.0
    for k in range(n + 1):
        a, b = (x + k * dx) / CELL_M + 0.5, (y + k * dy) / CELL_M + 0.5
        low_a, low_b = np.floor(a), np.floor(b)
        off = max(off, abs(a - low_a - 0.5), abs(b - low_b - 0.5))
        i, j = int(low_a) + half, int(low_b) + half
        if 0 <= i < explored.shape[0] and 0 <= j < explored.shape[1] and explored[i, j] == 0:
            explored[i, j] = 1
            fresh += 1
    return fresh, 0.5 - off


@merged
def shows(x: float, y: float, z: float, px: float, py: float, pz: float, hollow: F64, faces: int) -> bool:
    """Whether a camera looks at a point in a compartment through one of its open sides.

    Args:
        x: of the camera, metres.
        y: of the camera, metres.
        z: of the camera, metres.
        px: of the point, metres.
        py: of the point, metres.
        pz: of the point, metres.
        hollow: (6,) box of the compartment: x0 y0 z0 x1 y1 z1 in metres.
        faces: bits of its open sides; ALL_OPEN for points in no compartment.
    """
    if faces == ALL_OPEN:
        return True
    best, side = 1.0, -1
    dx, dy, dz = x - px, y - py, z - pz
    if dx != 0.0:
        t = ((hollow[3] if dx > 0 else hollow[0]) - px) / dx
        if t < best:
            best, side = t, 1 if dx > 0 else 0
    if dy != 0.0:
        t = ((hollow[4] if dy > 0 else hollow[1]) - py) / dy
        if t < best:
            best, side = t, 3 if dy > 0 else 2
    if dz != 0.0:
        t = ((hollow[5] if dz > 0 else hollow[2]) - pz) / dz
        if t < best:
            best, side = t, 5 if dz > 0 else 4
    return side < 0 or (faces >> side) & 1 == 1


@jit
def look(
    depth: F32,
    camera: F64,
    reach_m: float,
    places: F64,
    hollow: F64,
    faces: U8,
    active: Flags,
    unseen: F64,
    miss: float,
) -> int:
    """Lower ``unseen`` of the sample points that a frame shows.

    A point is shown if the ray through it ends at it or behind it (5 cm of tolerance), and enters the point's
    compartment through an open side.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        reach_m: greatest optical depth, metres.
        places: (n, 3) float64, the points, metres.
        hollow: (n, 6) float64, boxes of their compartments, metres.
        faces: (n,) uint8, bits of the compartments' open sides.
        active: (n,) bool, points to look at.
        unseen: (n,) float64, multiplied by ``miss`` at points that are shown.
        miss: probability that a frame that shows a point misses a target there.

    Returns:
        How many points are shown.
    """
    shown = 0
    for n in range(places.shape[0]):
        if not active[n]:
            continue
        if _shown_at(depth, camera, reach_m, places[n], hollow[n], faces[n]) > 0.0:
            unseen[n] *= miss
            shown += 1
    return shown


@jit
def look_from(depth: F32, camera: F64, places: F64, hollow: F64, faces: U8, active: Flags, near: F64) -> None:
    """Lower ``near`` of the sample points that a frame shows to their depth in it; see :func:`look`.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        places: (n, 3) float64, the points, metres.
        hollow: (n, 6) float64, boxes of their compartments, metres.
        faces: (n,) uint8, bits of the compartments' open sides.
        active: (n,) bool, points to look at.
        near: (n,) float64, lowered to the optical depth of points that are shown, metres.
    """
    for n in range(places.shape[0]):
        if active[n]:
            optical = _shown_at(depth, camera, near[n], places[n], hollow[n], faces[n])
            if optical > 0.0:
                near[n] = optical


@merged
def _shown_at(depth: F32, camera: F64, reach_m: float, place: F64, hollow: F64, faces: int) -> float:
    """Optical depth of a point in a frame, metres; 0 where the frame does not show it, or from beyond ``reach_m``."""
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    dx, dy, dz = place[0] - x, place[1] - y, place[2] - cam_z
    flat, right = c * dx + s * dy, s * dx - c * dy
    optical, up = cp * flat + sp * dz, cp * dz - sp * flat
    if optical <= 0.15 or optical > reach_m:
        return 0.0
    u = int(np.floor(0.5 * columns + focal_px * right / optical))
    v = int(np.floor(0.5 * rows - focal_px * up / optical))
    if not (0 <= u < columns and 0 <= v < rows and depth[v, u] > optical - 0.05):
        return 0.0
    return optical if shows(x, y, cam_z, place[0], place[1], place[2], hollow, faces) else 0.0
