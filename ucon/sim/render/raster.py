"""The visibility buffer: for each pixel the nearest face and one over its depth.

Faces are scan-converted into spans. Where two faces are equally near, the one with the lower number wins, so the
picture does not depend on the order of drawing, and leaving out what cannot be seen changes no pixel.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ucon.sim.render.kernels import F32, F64, I16, I32, jit
from ucon.sim.render.portals import half_angle, room_at, room_order, visible_rooms
from ucon.sim.render.shapes import INDEX, MOST_CORNERS, MOST_SIDES

NEAR_M = 0.05
_NEAR = np.float32(NEAR_M)
_HALF = np.float32(0.5)
_ZERO = np.float32(0.0)
_ONE = np.float32(1.0)
_SLACK = np.float32(-1e-4)
"""Boxes are culled when they lie this far (m) outside, which bears the rounding of the planes."""

CAMERA_FIELDS = ("x", "y", "z", "cos_yaw", "sin_yaw", "cos_pitch", "sin_pitch", "tan_half", "sample_x", "sample_y")


@jit
def camera_frame(camera: F64, frame: F32) -> None:
    """Rows of ``frame`` (4, 3): right, up, forward, position."""
    c, s, cp, sp = camera[3], camera[4], camera[5], camera[6]
    frame[0, 0], frame[0, 1], frame[0, 2] = s, -c, 0.0
    frame[1, 0], frame[1, 1], frame[1, 2] = -c * sp, -s * sp, cp
    frame[2, 0], frame[2, 1], frame[2, 2] = c * cp, s * cp, sp
    frame[3, 0], frame[3, 1], frame[3, 2] = camera[0], camera[1], camera[2]


@jit
def _frustum(frame: F32, tan_x: float, tan_y: float, planes: F32) -> None:
    """Inward normals of near, left, right, bottom and top, all through the camera."""
    for k in range(3):
        right, up, ahead = frame[0, k], frame[1, k], frame[2, k]
        planes[0, k] = ahead
        planes[1, k] = ahead * np.float32(tan_x) + right
        planes[2, k] = ahead * np.float32(tan_x) - right
        planes[3, k] = ahead * np.float32(tan_y) + up
        planes[4, k] = ahead * np.float32(tan_y) - up


@jit
def _outside(box: F32, planes: F32, count: int, frame: F32) -> bool:
    """Whether a box lies wholly behind one of the planes."""
    x0, y0, z0 = box[0] - frame[3, 0], box[1] - frame[3, 1], box[2] - frame[3, 2]
    x1, y1, z1 = box[3] - frame[3, 0], box[4] - frame[3, 1], box[5] - frame[3, 2]
    for k in range(count):
        a, b, c = planes[k, 0], planes[k, 1], planes[k, 2]
        reach = a * (x1 if a > _ZERO else x0) + b * (y1 if b > _ZERO else y0) + c * (z1 if c > _ZERO else z0)
        if reach < _SLACK:
            return True
    return False


@jit
def rasterise(
    camera: F64,
    tables: Any,
    rooms: F32,
    portals: F64,
    wall_height: float,
    room_start: I32,
    room_groups: I32,
    drawn: I32,
    stamp: int,
    cull: bool,
    inverse_depth: F32,
    faces: I32,
) -> None:
    """Fill ``inverse_depth`` and ``faces`` (H, W); 0 and -1 where there is nothing.

    ``drawn`` (np,) int32 remembers by ``stamp`` which parts this frame has drawn. Without ``cull`` every part is
    drawn, which must give the same picture.
    """
    height, width = faces.shape
    inverse_depth[:] = _ZERO
    faces[:] = -1
    frame = np.empty((4, 3), np.float32)
    camera_frame(camera, frame)
    tan_x = camera[7]
    tan_y = tan_x * height / width
    planes = np.empty((7, 3), np.float32)
    _frustum(frame, tan_x, tan_y, planes)
    n_rooms = rooms.shape[0]
    low, high = np.empty(n_rooms), np.empty(n_rooms)
    order = np.empty(n_rooms, np.int64)
    room_order(rooms, camera[0], camera[1], order)
    own = room_at(rooms, camera[0], camera[1])
    portal_culling = cull and own >= 0 and camera[2] < wall_height
    yaw = math.atan2(camera[4], camera[3])
    if portal_culling:
        visible_rooms(rooms, portals, camera[0], camera[1], yaw, own, _half(camera, tan_x, tan_y), low, high)
    scratch = np.empty((8, max(MOST_CORNERS, 2 * MOST_SIDES, height)), np.float32)
    view = (width, height, np.float32(width / 2 / tan_x), camera[8], camera[9])
    for k in range(n_rooms):
        r = order[k]
        if portal_culling and low[r] > high[r]:
            continue
        count = 5
        if portal_culling and r != own and high[r] - low[r] < 3.1:
            planes[5, 0], planes[5, 1] = -math.sin(yaw + low[r]), math.cos(yaw + low[r])
            planes[6, 0], planes[6, 1] = math.sin(yaw + high[r]), -math.cos(yaw + high[r])
            planes[5, 2] = planes[6, 2] = _ZERO
            count = 7
        for i in range(room_start[r], room_start[r + 1]):
            g = room_groups[i]
            if cull and _outside(tables.group_boxes[g], planes, count, frame):
                continue
            first = tables.groups[g, 0]
            for p in range(first, first + tables.groups[g, 1]):
                if drawn[p] == stamp or (cull and _outside(tables.part_boxes[p], planes, count, frame)):
                    continue
                drawn[p] = stamp
                _draw_part(p, tables, frame, view, scratch, inverse_depth, faces)


@jit
def _half(camera: F64, tan_x: float, tan_y: float) -> float:
    return half_angle(camera[5], camera[6], tan_x, tan_y)


@jit
def _draw_part(p: int, tables: Any, frame: F32, view: Any, scratch: F32, inverse_depth: F32, faces: I32) -> None:
    """Project the corners of a part and draw those of its faces that look at the camera."""
    width, height, scale, sample_x, sample_y = view
    middle_x = np.float32(width * 0.5 + (0.5 - sample_x))
    middle_y = np.float32(height * 0.5 + (0.5 - sample_y))
    cx, cy, cz = frame[3, 0], frame[3, 1], frame[3, 2]
    rx, ry = frame[0, 0], frame[0, 1]
    ux, uy, uz = frame[1, 0], frame[1, 1], frame[1, 2]
    fx, fy, fz = frame[2, 0], frame[2, 1], frame[2, 2]
    xs, ys, ws = scratch[0], scratch[1], scratch[2]
    first = tables.parts[p, 0]
    vertices = tables.vertices
    nearest = np.float32(1e9)
    for i in range(tables.parts[p, 1]):
        dx, dy, dz = vertices[first + i, 0] - cx, vertices[first + i, 1] - cy, vertices[first + i, 2] - cz
        xs[i] = dx * rx + dy * ry
        ys[i] = dx * ux + dy * uy + dz * uz
        ws[i] = dx * fx + dy * fy + dz * fz
        nearest = min(nearest, ws[i])
    whole = nearest >= _NEAR
    if whole:
        left, right, top, bottom = np.float32(1e9), np.float32(-1e9), np.float32(1e9), np.float32(-1e9)
        for i in range(tables.parts[p, 1]):
            inverse = scale / ws[i]
            xs[i] = middle_x + xs[i] * inverse
            ys[i] = middle_y - ys[i] * inverse
            left, right = min(left, xs[i]), max(right, xs[i])
            top, bottom = min(top, ys[i]), max(bottom, ys[i])
        if _first(left) >= _last(right, width) or _first(top) >= _last(bottom, height):
            return
    step = _ONE / scale
    px, py = scratch[3], scratch[4]
    for f in range(tables.parts[p, 2], tables.parts[p, 2] + tables.parts[p, 3]):
        nx, ny, nz = tables.face_planes[f, 0], tables.face_planes[f, 1], tables.face_planes[f, 2]
        distance = tables.face_planes[f, 3] - (nx * cx + ny * cy + nz * cz)
        if distance >= np.float32(-1e-6):
            continue
        start, corners = tables.face_topology[f, 0], tables.face_topology[f, 1]
        if whole:
            for k in range(corners):
                j = INDEX[start + k]
                px[k], py[k] = xs[j], ys[j]
        else:
            corners = _clip_near(start, corners, scratch, scale, middle_x, middle_y)
        over = _ONE / distance
        a = (nx * rx + ny * ry) * step * over
        b = -(nx * ux + ny * uy + nz * uz) * step * over
        c = (nx * fx + ny * fy + nz * fz) * over + a * (_HALF - middle_x) + b * (_HALF - middle_y)
        _fill(f, corners, a, b, c, scratch, inverse_depth, faces)


@jit
def _clip_near(start: int, corners: int, scratch: F32, scale: float, middle_x: float, middle_y: float) -> int:
    """Cut a face at the near plane and project what is left; returns its corners."""
    xs, ys, ws, px, py = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4]
    m = 0
    for k in range(corners):
        i, j = INDEX[start + k], INDEX[start + (k + 1 if k + 1 < corners else 0)]
        if ws[i] >= _NEAR:
            inverse = scale / ws[i]
            px[m], py[m] = middle_x + xs[i] * inverse, middle_y - ys[i] * inverse
            m += 1
        if (ws[i] >= _NEAR) != (ws[j] >= _NEAR):
            t = (_NEAR - ws[i]) / (ws[j] - ws[i])
            inverse = scale / _NEAR
            px[m] = middle_x + (xs[i] + t * (xs[j] - xs[i])) * inverse
            py[m] = middle_y - (ys[i] + t * (ys[j] - ys[i])) * inverse
            m += 1
    return m


@jit
def _first(position: float) -> int:
    """First pixel whose centre lies beyond ``position``, not below 0."""
    return np.int32(max(position, -_HALF) + _HALF)


@jit
def _last(position: float, size: int) -> int:
    """One past the last pixel whose centre lies before ``position``, at most ``size``."""
    return np.int32(min(max(position, -_HALF), np.float32(size)) + _HALF)


@jit
def _fill(f: int, m: int, a: float, b: float, c: float, scratch: F32, inverse_depth: F32, faces: I32) -> None:
    """Scan-convert a convex polygon with m corners and the depth plane ``a x + b y + c``.

    Corners run counter-clockwise, so edges that go down the picture bound it on the left.
    """
    height, width = faces.shape
    px, py, left, right = scratch[3], scratch[4], scratch[5], scratch[6]
    top, bottom = np.float32(1e9), np.float32(-1e9)
    for k in range(m):
        top, bottom = min(top, py[k]), max(bottom, py[k])
    y0, y1 = _first(top), _last(bottom, height)
    if m < 3 or y0 >= y1:
        return
    for k in range(m):
        l = k + 1 if k + 1 < m else 0
        if py[k] < py[l]:
            _edge(px[k], py[k], px[l], py[l], left, height)
        elif py[k] > py[l]:
            _edge(px[l], py[l], px[k], py[k], right, height)
    face = np.int32(f)
    for y in range(y0, y1):
        x0, x1 = _first(left[y]), _last(right[y], width)
        if x0 >= x1:
            continue
        row_z = c + b * np.float32(y)
        z_row, f_row = inverse_depth[y, x0:x1], faces[y, x0:x1]
        for x in range(x1 - x0):
            z = row_z + a * np.float32(x + x0)
            nearer = z > z_row[x] or (z == z_row[x] and face < f_row[x])
            z_row[x] = z if nearer else z_row[x]
            f_row[x] = face if nearer else f_row[x]


@jit
def _edge(x_top: float, y_top: float, x_low: float, y_low: float, bound: F32, height: int) -> None:
    """Where an edge crosses the centre of each row."""
    start, end = _first(y_top), _last(y_low, height)
    slope = (x_low - x_top) / (y_low - y_top)
    for y in range(start, end):
        bound[y] = x_top + (np.float32(y) + _HALF - y_top) * slope
