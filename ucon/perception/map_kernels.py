"""Hot loops of the semantic map: depth to cells, boxes and explored space; what a frame shows of expected places.

Cells are 0.25 m and centred on the nodes the agent can stand on: cell (i, j) holds x in [i - half ± 0.5] * 0.25.
Frames: camera at ``cam_z`` metres, 90-degree-style pinhole with focal ``focal_px``, heading as exact cosine and sine.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CELL_M = 0.25
#: Obstacles closer than this to a node make it impassable (the robot's radius).
RADIUS_M = 0.18
LOW_M, TALL_M = 0.05, 1.8
#: Heights above this do not hide what is below a lintel or a top cabinet from the camera.
LINTEL_M = 1.9
FLOORS, WALLS, CEILINGS = 1, 2, 3


@njit(cache=True, nogil=True, error_model="numpy")
def integrate(
    depth, tracks, x, y, cam_z, c, s, cp, sp, focal_px, half,
    height, near, floor, blocked, kind, frozen, box, track_near, track_pixels,
):  # fmt: skip
    """Put one frame into the cell maps and the boxes of its tracks.

    depth (H, W) float32 metres along the optical axis; tracks (H, W) int16. Structure is read at every second pixel,
    things at every pixel, because a thing may be four pixels small.
    """
    rows, columns = depth.shape
    n_tracks, n_cells = kind.shape[0], height.shape[0]
    for v in range(rows):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead, rise = cp - sp * up, sp + cp * up
        for u in range(columns):
            t = tracks[v, u]
            d = depth[v, u]
            if t < 0 or t >= n_tracks or not (0.0 < d < 60.0):
                continue
            k = kind[t]
            if k != 0 and (u & 1 or v & 1):
                continue
            right = d * ((u + 0.5 - 0.5 * columns) / focal_px)
            f = d * ahead
            px, py, pz = x + c * f + s * right, y + s * f - c * right, cam_z + d * rise
            i, j = int(np.floor(px / CELL_M + 0.5)) + half, int(np.floor(py / CELL_M + 0.5)) + half
            if i < 1 or j < 1 or i >= n_cells - 1 or j >= n_cells - 1:
                continue
            if d < near[i, j]:
                near[i, j] = d
            if k == 0:
                track_pixels[t] += 1
                if d < track_near[t]:
                    track_near[t] = d
                if not frozen[t]:
                    box[t, 0], box[t, 3] = min(box[t, 0], px), max(box[t, 3], px)
                    box[t, 1], box[t, 4] = min(box[t, 1], py), max(box[t, 4], py)
                    box[t, 2], box[t, 5] = min(box[t, 2], pz), max(box[t, 5], pz)
            if k == CEILINGS:
                continue
            if pz < LOW_M:
                floor[i, j] = 1
                continue
            if pz < LINTEL_M and pz > height[i, j]:
                height[i, j] = pz
            if pz < TALL_M and not frozen[t]:
                _block(blocked, i, j, px - (i - half) * CELL_M, py - (j - half) * CELL_M)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _block(blocked, i, j, dx, dy):
    """Mark the nodes around an obstacle point (dx, dy metres from node (i, j)) that it makes impassable."""
    for a in range(-1, 2):
        for b in range(-1, 2):
            ex, ey = dx - a * CELL_M, dy - b * CELL_M
            if ex * ex + ey * ey < RADIUS_M * RADIUS_M:
                blocked[i + a, j + b] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def carve(depth, x, y, c, s, cp, sp, focal_px, half, explored, reach_m):
    """Mark the cells that sight lines pass over as explored. Returns how many became so."""
    rows, columns = depth.shape
    n_cells, fresh = explored.shape[0], 0
    for v in range(4, rows, 8):
        up = (0.5 * rows - v - 0.5) / focal_px
        ahead = cp - sp * up
        for u in range(0, columns, 2):
            d = depth[v, u]
            if not d > 0.0:
                continue
            d = min(d, 60.0)
            f, right = d * ahead, d * ((u + 0.5 - 0.5 * columns) / focal_px)
            hx, hy = c * f + s * right, s * f - c * right
            length = np.sqrt(hx * hx + hy * hy)
            n = int(min(length - 0.02, reach_m) / 0.125)
            if n <= 0:
                continue
            hx, hy = 0.125 * hx / length, 0.125 * hy / length
            for k in range(n + 1):
                i = int(np.floor((x + k * hx) / CELL_M + 0.5)) + half
                j = int(np.floor((y + k * hy) / CELL_M + 0.5)) + half
                if 0 <= i < n_cells and 0 <= j < n_cells and explored[i, j] == 0:
                    explored[i, j] = 1
                    fresh += 1
    return fresh


@njit(cache=True, nogil=True, error_model="numpy")
def look(depth, x, y, cam_z, c, s, cp, sp, focal_px, reach_m, place, active, unseen, miss):
    """Lower ``unseen`` (n,) of the places (n, 3) that this frame shows from within ``reach_m``; returns the count.

    A place counts as shown where the ray through it ends at it or behind it (8 cm of grace).
    """
    rows, columns = depth.shape
    shown = 0
    for n in range(place.shape[0]):
        if not active[n]:
            continue
        dx, dy, dz = place[n, 0] - x, place[n, 1] - y, place[n, 2] - cam_z
        flat, right = c * dx + s * dy, s * dx - c * dy
        optical, up = cp * flat + sp * dz, cp * dz - sp * flat
        if optical <= 0.15 or optical > reach_m:
            continue
        u = int(np.floor(0.5 * columns + focal_px * right / optical))
        v = int(np.floor(0.5 * rows - focal_px * up / optical))
        if 0 <= u < columns and 0 <= v < rows and depth[v, u] > optical - 0.08:
            unseen[n] *= miss
            shown += 1
    return shown
