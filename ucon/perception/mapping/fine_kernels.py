"""Kernels of the 5 cm map: from one frame to obstacles and explored space, and path lengths around obstacles.

Cells are 5 cm, five to the side of a cell of the 0.25 m map: cell (a, b) lies in (a // 5, b // 5). A map is one uint8
array of bits, so that a frame touches one array only. The camera is that of :mod:`ucon.perception.mapping.map_kernels`.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I32, U8, Flags, jit, merged
from ucon.perception.mapping.map_kernels import CELL_M

PER_CELL = 5
FINE_M = CELL_M / PER_CELL
OBSTACLE, EXPLORED, VISITED = 1, 2, 4
#: Bits of the frame being added: a point below, or within, the heights of obstacles.
_LOW, _HIGH = 8, 16
#: Points at optical depths between these are used, metres, as in L3MVN.
NEAREST_M, FARTHEST_M = 0.5, 5.0
#: Points from LOWEST_M to HIGHEST_M above the floor count as explored; obstacles are points from OBSTACLE_M above the
#: floor to ABOVE_M above the camera. Metres.
LOWEST_M, HIGHEST_M, OBSTACLE_M, ABOVE_M = -0.4, 2.0, 0.25, 0.5
#: Cells under a sight line count as explored up to this many metres ahead. Beyond that, L3MVN's points lie too far
#: apart for its 5 x 5 closing.
CARVE_M = 4.5
#: Sight lines are binned by their slope (sideways over ahead), from -2 to 2 in steps of 1 / 64, as the columns of a
#: level 128 x 128 view.
BINS = 256
_SLOPES = 64.0
#: Three neighbouring pixels lie on one plane if their inverse depths are linear to within this, in 1 / m.
_PLANE = 0.003


@jit
def add_frame(depth: F32, camera: F64, half: int, cells: U8, bounds: I32, touched: I32, reach: F64) -> None:
    """Add one frame to the map.

    Args:
        depth: (H, W) float32, metres along the optical axis, 0 where there is none.
        camera: (8,) float64.
        half: cell number of the start.
        cells: (n, n) uint8 bits, updated.
        bounds: (4,) int32, updated: least and greatest a, least and greatest b ever marked.
        touched: (65536,) int32, working memory.
        reach: (BINS,) float64, working memory.
    """
    count = _points(depth, camera, half, cells, touched)
    count = _surfaces(depth, camera, half, cells, touched, count)
    _settle(cells, bounds, touched, count, camera[6] == 0.0)
    _sight_lines(depth, camera, reach)
    _carve(camera, half, cells, bounds, reach)


@merged
def _mark(cells: U8, a: int, b: int, bits: int, touched: I32, count: int) -> int:
    """Set bits of a cell and list it in ``touched`` the first time in a frame; returns how many cells are listed."""
    old = cells[a, b]
    if old & bits != bits:
        cells[a, b] = old | bits
        if old & (_LOW | _HIGH) == 0 and count < touched.shape[0]:
            touched[count] = a * cells.shape[0] + b
            return count + 1
    return count


@jit
def _points(depth: F32, camera: F64, half: int, cells: U8, touched: I32) -> int:
    """Mark the cells of all points of the frame; returns how many cells are listed in ``touched``."""
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    origin_a, origin_b, scale = x / FINE_M + half + 0.5, y / FINE_M + half + 0.5, 1.0 / FINE_M
    per_px, last, top = scale / focal_px, cells.shape[0] - 2, cam_z + ABOVE_M
    count = 0
    for v in range(rows):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = (cp - sp * up) * scale, sp + cp * up
        for u in range(columns):
            d = depth[v, u]
            z = cam_z + d * rise
            # Farther away the rows of floor points are too far apart to join: each would get an edge of its own.
            if not (NEAREST_M < d < (CARVE_M if z < OBSTACLE_M else FARTHEST_M) and LOWEST_M < z < HIGHEST_M):
                continue
            side = (u + 0.5 - 0.5 * columns) * per_px
            a, b = int(origin_a + d * (c * ahead + s * side)), int(origin_b + d * (s * ahead - c * side))
            if 0 < a <= last and 0 < b <= last:
                bits = EXPLORED | _LOW if z < OBSTACLE_M else OBSTACLE | EXPLORED | _HIGH if z < top else EXPLORED
                count = _mark(cells, a, b, bits, touched, count)
    return count


@jit
def _sight_lines(depth: F32, camera: F64, reach: F64) -> None:
    """Write to ``reach`` (BINS,) how far ahead the sight lines of each slope reach, in metres.

    Every second row of the image is used.
    """
    rows, columns = depth.shape
    _, _, cam_z, _, _, cp, sp, focal_px = camera
    top = min(ABOVE_M, HIGHEST_M - cam_z)
    reach[:] = 0.0
    for v in range(0, rows, 2):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = cp - sp * up, sp + cp * up
        if ahead < 0.2:
            continue
        # A sight line above the height of obstacles may pass over a cupboard, so it is cut off at that height.
        far = min(CARVE_M, top * ahead / rise) if rise > 0.0 else CARVE_M
        slope = _SLOPES / (ahead * focal_px)
        for u in range(columns):
            f = min(depth[v, u] * ahead, far)
            k = int((u + 0.5 - 0.5 * columns) * slope + 0.5 * BINS)
            if 0 <= k < BINS and f > reach[k]:
                reach[k] = f


@jit
def _surfaces(depth: F32, camera: F64, half: int, cells: U8, touched: I32, count: int) -> int:
    """Join neighbouring points of a wall that is seen at a flat angle; returns how many cells are in ``touched``.

    Every fourth row of the image is used.
    """
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    top = min(cam_z + ABOVE_M, HIGHEST_M)
    for v in range(2, rows, 4):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = cp - sp * up, sp + cp * up
        for u in range(1, columns - 1):
            d0, d1, d2 = depth[v, u - 1], depth[v, u], depth[v, u + 1]
            if not (d0 > NEAREST_M and d1 > NEAREST_M and d2 > NEAREST_M):
                continue
            if max(d0, d1, d2) >= FARTHEST_M or abs(1.0 / d0 - 2.0 / d1 + 1.0 / d2) > _PLANE:
                continue
            if not OBSTACLE_M <= cam_z + d1 * rise < top:
                continue
            side = (u + 0.5 - 0.5 * columns) / focal_px
            here = (d1 * ahead, d1 * side)
            # Only half way: the neighbour fills the other half, if it lies on a plane too.
            before = (0.5 * (d0 + d1) * ahead, 0.5 * (d0 * (side - 1.0 / focal_px) + d1 * side))
            after = (0.5 * (d2 + d1) * ahead, 0.5 * (d2 * (side + 1.0 / focal_px) + d1 * side))
            for f, g in (before, after):
                n = int(max(abs(f - here[0]), abs(g - here[1])) / FINE_M + 0.5)
                for m in range(1, n + 1):
                    fm, gm = here[0] + m * (f - here[0]) / n, here[1] + m * (g - here[1]) / n
                    a = int((x + c * fm + s * gm) / FINE_M + half + 0.5)
                    b = int((y + s * fm - c * gm) / FINE_M + half + 0.5)
                    if 0 < a < cells.shape[0] - 1 and 0 < b < cells.shape[0] - 1:
                        count = _mark(cells, a, b, OBSTACLE | EXPLORED | _HIGH, touched, count)
    return count


@jit
def _settle(cells: U8, bounds: I32, touched: I32, count: int, level: bool) -> None:
    """Clear obstacles that are gone, widen the bounds, and remove the frame's own bits.

    Only a frame with a level camera clears. An obstacle is gone if only lower points were seen at its cell and no
    obstacle point of this frame lies in the 3 x 3 cells around.
    """
    n = cells.shape[0]
    for k in range(count):
        a, b = touched[k] // n, touched[k] % n
        bounds[0], bounds[1] = min(bounds[0], a), max(bounds[1], a)
        bounds[2], bounds[3] = min(bounds[2], b), max(bounds[3], b)
        if level and cells[a, b] & OBSTACLE and cells[a, b] & _HIGH == 0:
            near = 0
            for i in range(a - 1, a + 2):
                for j in range(b - 1, b + 2):
                    near |= cells[i, j]
            if near & _HIGH == 0:
                cells[a, b] &= 255 - OBSTACLE
    for k in range(count):
        cells[touched[k] // n, touched[k] % n] &= 255 - (_LOW | _HIGH)


@jit
def _carve(camera: F64, half: int, cells: U8, bounds: I32, reach: F64) -> None:
    """Mark the cells under the sight lines as explored."""
    x, y, _, c, s = camera[:5]
    last = cells.shape[0] - 2
    for k in range(BINS):
        if not reach[k] > 0.02:
            continue
        slope = (k + 0.5 - 0.5 * BINS) / _SLOPES
        n = int((reach[k] - 0.02) * max(1.0, abs(slope)) / FINE_M)
        step = 1.0 / max(1.0, abs(slope))
        da, db = (c + s * slope) * step, (s - c * slope) * step
        pa, pb = x / FINE_M + half + 0.5, y / FINE_M + half + 0.5
        for _step in range(n + 1):
            a, b = min(max(int(pa), 1), last), min(max(int(pb), 1), last)
            cells[a, b] |= EXPLORED
            pa, pb = pa + da, pb + db
        bounds[0], bounds[1] = min(bounds[0], a), max(bounds[1], a)
        bounds[2], bounds[3] = min(bounds[2], b), max(bounds[3], b)


@jit
def walk(blocked: U8, a: int, b: int, limit: float, out: F32, queue: I32, waiting: Flags) -> None:
    """Lengths of the shortest paths from one cell, in cells.

    Solves the first-order upwind scheme of fast marching. Cells are updated from a queue until none changes; the
    solution does not depend on the order of updates. Cells at the border are never entered.

    Args:
        blocked: (n, n) uint8, not 0 where there is an obstacle.
        a: row of the start.
        b: column of the start.
        limit: longer paths are inf; cells.
        out: (n, n) float32, written.
        queue: (n * n,) int32, working memory.
        waiting: (n, n) bool, working memory; all False before and after.
    """
    n = blocked.shape[0]
    out[:] = np.inf
    out[a, b] = 0.0
    queue[0], waiting[a, b] = a * n + b, True
    head, left = 0, 1
    while left > 0:
        i, j = queue[head] // n, queue[head] % n
        head, left = (head + 1) % (n * n), left - 1
        waiting[i, j] = False
        for k in range(4):
            p, q = i + (1, 0, -1, 0)[k], j + (0, 1, 0, -1)[k]
            if p < 1 or q < 1 or p >= n - 1 or q >= n - 1 or blocked[p, q]:
                continue
            way = _upwind(out, p, q)
            if way < out[p, q] - 1e-3 and way <= limit:
                out[p, q] = way
                if not waiting[p, q]:
                    queue[(head + left) % (n * n)] = p * n + q
                    waiting[p, q] = True
                    left += 1


@merged
def _upwind(out: F32, p: int, q: int) -> float:
    """Path length to a cell, from those of its four neighbours."""
    u, v = min(out[p - 1, q], out[p + 1, q]), min(out[p, q - 1], out[p, q + 1])
    if abs(u - v) < 1.0:
        return 0.5 * (u + v + np.sqrt(2.0 - (u - v) * (u - v)))
    return min(u, v) + 1.0
