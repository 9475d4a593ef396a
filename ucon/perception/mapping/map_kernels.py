"""Hot loops of the semantic map: depth to cells, boxes and explored space; what a frame shows of expected places.

Cells are 0.25 m and centred on the nodes the agent can stand on: cell (i, j) holds x in (i - half ± 0.5) * 0.25.
A camera is the float64 array (x, y, z, cos yaw, sin yaw, cos pitch, sin pitch, focal length in pixels).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, U8, Flags, jit, merged

CELL_M = 0.25
#: Bits of the sides -x, +x, -y, +y, -z, +z of a hollow.
ALL_OPEN = 63
#: Obstacles closer than this to a node make it impassable (the robot's radius).
RADIUS_M = 0.18
LOW_M, TALL_M = 0.05, 1.8
#: Heights above this do not hide what is below a lintel or a top cabinet from the camera.
LINTEL_M = 1.9
FAR_M = 60.0
FLOORS, WALLS, CEILINGS = 1, 2, 3
#: Steps of sight lines that differ by less than this end in the same cells, if those of one of them, 64 at most, stay
#: this far (in cells) from all borders.
_ALIKE_M, _CLEAR = 1e-12, 1e-9


@jit
def integrate(depth: F32, tracks: I16, camera: F64, half: int, cells: Any, kind: U8, frozen: Flags, box: F64) -> None:
    """Put one frame into the cell maps and the boxes of its tracks.

    depth (H, W) optical metres; tracks (H, W); cells = (height, near, floor, blocked, walls); kind, frozen (T,),
    box (T, 6). Cells are read from every second pixel, boxes from every one: a thing may be four pixels.
    """
    rows, columns = depth.shape
    point, cell, aside = np.empty((3, columns)), np.empty((2, columns), np.int32), np.empty(columns)
    for u in range(columns):
        aside[u] = (u + 0.5 - 0.5 * columns) / camera[7]
    for v in range(rows):
        # The arithmetic of a whole row goes first, where it can be done for several pixels at once.
        _project(depth[v], (0.5 * rows - v - 0.5) / camera[7], aside, camera, point)
        _widen(depth[v], tracks[v], point, kind, frozen, box)
        if v & 1 == 0:
            _cells(point, half, cell)
            _mark(depth[v], tracks[v], point, cell, half, cells, kind, frozen)


@jit
def _project(depth: F32, up: float, aside: F64, camera: F64, point: F64) -> None:
    """Write the points (3, W) that the pixels of a row show, in metres."""
    x, y, cam_z, c, s, cp, sp, _ = camera
    ahead, rise = cp - sp * up, sp + cp * up
    for u in range(depth.shape[0]):
        d = depth[u]
        f, right = d * ahead, d * aside[u]
        point[0, u], point[1, u], point[2, u] = x + c * f + s * right, y + s * f - c * right, cam_z + d * rise


@jit
def _cells(point: F64, half: int, cell: I32) -> None:
    """Write the cells (2, W) that the points (3, W) are in."""
    for u in range(point.shape[1]):
        cell[0, u] = np.int32(np.floor(point[0, u] / CELL_M + 0.5)) + half
        cell[1, u] = np.int32(np.floor(point[1, u] / CELL_M + 0.5)) + half


@jit
def _widen(depth: F32, tracks: I16, point: F64, kind: U8, frozen: Flags, box: F64) -> None:
    """Widen the boxes by the points of a row, for each stretch of one track at once."""
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
def _mark(depth: F32, tracks: I16, point: F64, cell: I32, half: int, cells: Any, kind: U8, frozen: Flags) -> None:
    """Note every second point of a row in the cell maps."""
    height, near, floor, blocked, walls = cells
    last = height.shape[0] - 1
    for u in range(0, depth.shape[0], 2):
        t, d, i, j = tracks[u], depth[u], cell[0, u], cell[1, u]
        if t < 0 or t >= kind.shape[0] or not (0.0 < d < FAR_M) or i < 1 or j < 1 or i >= last or j >= last:
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
    """Mark the cell border that a wall point lies by: walls stand on borders, their faces 5 cm beside them.

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
    """Mark the nodes around an obstacle point (dx, dy metres from node (i, j)) that it makes impassable.

    It is in the node's own cell, so that the others on its far sides are never near enough. No branches: they would
    be guessed wrong half the time.
    """
    a, b = i + (1 if dx > 0.0 else -1), j + (1 if dy > 0.0 else -1)
    ex, ey = CELL_M - abs(dx), CELL_M - abs(dy)
    blocked[i, j] = 1
    blocked[a, j] |= ex * ex + dy * dy < RADIUS_M * RADIUS_M
    blocked[i, b] |= dx * dx + ey * ey < RADIUS_M * RADIUS_M
    blocked[a, b] |= ex * ex + ey * ey < RADIUS_M * RADIUS_M


@jit
def carve(depth: F32, camera: F64, half: int, explored: U8, reach_m: float) -> int:
    """Mark the cells that sight lines pass over as explored. Returns how many became so.

    Those of one column of a level picture lie over each other: of these only the longest is followed.
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
    """Write the step (dx, dy) of a pixel's sight line over the floor, in metres, and how many of them it has."""
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
    """Mark the cells of n steps from a point; how many are new, and how clear of cell borders all steps are (cells)."""
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
    """Whether a camera at (x, y, z) looks at a point in a hollow (6,) through one of its open sides."""
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
    """Lower ``unseen`` (n,) of the places (n, 3) that this frame shows from within ``reach_m``; returns the count.

    A place counts as shown where the ray through it ends at it or behind it (5 cm of grace), and enters the hollow
    (n, 6) that it may be in through one of its open faces (n,).
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    shown = 0
    for n in range(places.shape[0]):
        if not active[n]:
            continue
        dx, dy, dz = places[n, 0] - x, places[n, 1] - y, places[n, 2] - cam_z
        flat, right = c * dx + s * dy, s * dx - c * dy
        optical, up = cp * flat + sp * dz, cp * dz - sp * flat
        if optical <= 0.15 or optical > reach_m:
            continue
        u = int(np.floor(0.5 * columns + focal_px * right / optical))
        v = int(np.floor(0.5 * rows - focal_px * up / optical))
        if not (0 <= u < columns and 0 <= v < rows and depth[v, u] > optical - 0.05):
            continue
        if shows(x, y, cam_z, places[n, 0], places[n, 1], places[n, 2], hollow[n], faces[n]):
            unseen[n] *= miss
            shown += 1
    return shown
