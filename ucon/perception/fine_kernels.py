"""Hot loops of the 5 cm map: one frame to obstacles and explored space; metres to walk around obstacles.

Cells are 5 cm, five to the side of a cell of the 0.25 m map: cell (a, b) lies in (a // 5, b // 5). A map is one uint8
array of bits, so that a frame touches one array only. The camera is that of :mod:`ucon.perception.map_kernels`.
"""

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, F64, I32, U8, Flags, jit, merged
from ucon.perception.map_kernels import CELL_M, FAR_M

PER_CELL = 5
FINE_M = CELL_M / PER_CELL
OBSTACLE, EXPLORED, VISITED = 1, 2, 4
#: Seen in the frame being added, below the obstacles' heights or within them.
_LOW, _HIGH = 8, 16
#: Points are used between these optical depths, as in L3MVN.
NEAREST_M, FARTHEST_M = 0.5, 5.0
#: Heights that count as explored, and that an obstacle has, from the floor or above the camera.
LOWEST_M, HIGHEST_M, OBSTACLE_M, ABOVE_M = -0.4, 2.0, 0.25, 0.5
#: Sight lines count as explored up to this far ahead. Beyond it L3MVN's points lie too far apart for its 5 x 5 closing.
CARVE_M = 4.5
#: One sight line for each class of directions: sideways over ahead, -2 to 2 by 1 / 64, a column of a level 128 x 128 view.
BINS = 256
_SLOPES = 64.0
#: Neighbouring pixels lie on one plane where their inverse depths are as good as linear (per metre).
_PLANE = 0.003


@jit
def add_frame(depth: F32, camera: F64, half: int, cells: U8, bounds: I32, touched: I32, reach: F64) -> None:
    """Put one frame into the map.

    depth (H, W) optical metres, pixels without depth 0; cells (n, n) bits; bounds (4,) least and greatest row and
    column ever marked; touched (65536,) and reach (BINS,) are room to work in.
    """
    reach[:] = 0.0
    count = _points(depth, camera, half, cells, touched, reach)
    count = _surfaces(depth, camera, half, cells, touched, count)
    _settle(cells, bounds, touched, count, camera[6] == 0.0)
    _carve(camera, half, cells, bounds, reach)


@merged
def _mark(cells: U8, a: int, b: int, bits: int, touched: I32, count: int) -> int:
    """Set bits of a cell and note it the first time in a frame; returns how many are noted."""
    n = cells.shape[0]
    if a < 1 or b < 1 or a >= n - 1 or b >= n - 1:
        return count
    old = cells[a, b]
    if old & bits != bits:
        cells[a, b] = old | bits
        if old & (_LOW | _HIGH) == 0 and count < touched.shape[0]:
            touched[count] = a * n + b
            return count + 1
    return count


@jit
def _points(depth: F32, camera: F64, half: int, cells: U8, touched: I32, reach: F64) -> int:
    """Mark the cells of all points, and find how far each class of sight lines reaches."""
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    origin_a, origin_b = x / FINE_M + half + 0.5, y / FINE_M + half + 0.5
    count = 0
    for v in range(rows):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = cp - sp * up, sp + cp * up
        # A sight line above all heights that count says nothing about what lies below it.
        far = min(CARVE_M, (HIGHEST_M - cam_z) * ahead / rise) if rise > 0.0 else CARVE_M
        per_ahead = _SLOPES / ahead if ahead > 0.2 else 0.0
        for u in range(columns):
            d = min(depth[v, u], FAR_M)
            if not d > 0.0:
                continue
            side, f, z = (u + 0.5 - 0.5 * columns) / focal_px, d * ahead, cam_z + d * rise
            if NEAREST_M < d < FARTHEST_M and LOWEST_M < z < HIGHEST_M:
                a = int(origin_a + (c * f + s * d * side) / FINE_M)
                b = int(origin_b + (s * f - c * d * side) / FINE_M)
                count = _mark(cells, a, b, _bits(z, cam_z), touched, count)
            k = int(side * per_ahead + 0.5 * BINS)
            if per_ahead > 0.0 and 0 <= k < BINS:
                reach[k] = max(reach[k], min(f, far))
    return count


@merged
def _bits(z: float, cam_z: float) -> int:
    """What a point of a height makes of its cell."""
    if z < OBSTACLE_M:
        return EXPLORED | _LOW
    if z < cam_z + ABOVE_M:
        return EXPLORED | OBSTACLE | _HIGH
    return EXPLORED


@jit
def _surfaces(depth: F32, camera: F64, half: int, cells: U8, touched: I32, count: int) -> int:
    """Close the gaps between neighbouring points of a wall that is seen at a flat angle; every fourth row will do."""
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    for v in range(2, rows, 4):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = cp - sp * up, sp + cp * up
        for u in range(1, columns - 1):
            d0, d1, d2 = depth[v, u - 1], depth[v, u], depth[v, u + 1]
            if not (d0 > NEAREST_M and d1 > NEAREST_M and d2 > NEAREST_M):
                continue
            if max(d0, d1, d2) >= FARTHEST_M or abs(1.0 / d0 - 2.0 / d1 + 1.0 / d2) > _PLANE:
                continue
            z = cam_z + d1 * rise
            if not OBSTACLE_M <= z < min(cam_z + ABOVE_M, HIGHEST_M):
                continue
            for k in (-1, 1):
                d = d0 if k < 0 else d2
                side, other = (u + 0.5 - 0.5 * columns) / focal_px, (u + k + 0.5 - 0.5 * columns) / focal_px
                f, g = d1 * side, d * other
                n = int(max(abs(d - d1) * abs(ahead), abs(f - g)) / FINE_M)
                for m in range(1, n + 1):
                    t = 0.5 * m / n  # to the middle; the neighbour does the rest, if it lies on a plane too
                    fm, gm = (d1 + t * (d - d1)) * ahead, f + t * (g - f)
                    a = int((x + c * fm + s * gm) / FINE_M + half + 0.5)
                    b = int((y + s * fm - c * gm) / FINE_M + half + 0.5)
                    count = _mark(cells, a, b, EXPLORED | OBSTACLE | _HIGH, touched, count)
    return count


@jit
def _settle(cells: U8, bounds: I32, touched: I32, count: int, level: bool) -> None:
    """Clear the obstacles that a level frame shows to be gone, widen the bounds, forget what was this frame's.

    Gone is one at whose cell only lower points were seen, with no obstacle of this frame in the 3 x 3 around.
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
    """Mark the cells that sight lines pass over as explored."""
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
    """Fill ``out`` (n, n) with the length in cells of the shortest way from (a, b) around ``blocked`` (n, n).

    Ways longer than ``limit`` are inf. Solves the first order upwind scheme of fast marching, whose solution does not
    depend on the order of updates: cells are updated from a queue until none changes. ``queue`` (n * n,) and
    ``waiting`` (n, n), all False, are room to work in. Cells at the border are never entered.
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
    """Length of the way to a cell by those of its four neighbours."""
    u, v = min(out[p - 1, q], out[p + 1, q]), min(out[p, q - 1], out[p, q + 1])
    if abs(u - v) < 1.0:
        return 0.5 * (u + v + np.sqrt(2.0 - (u - v) * (u - v)))
    return min(u, v) + 1.0
