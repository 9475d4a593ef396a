"""The visibility buffer: for each pixel the nearest face and one over its depth.

Faces are scan-converted into spans. Where two faces are equally near, the one with the lower number wins, so the
picture does not depend on the order of drawing, and leaving out what cannot be seen changes no pixel.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.sim.render.kernels import F32, F64, I32, jit, leaf
from ucon.sim.render.portals import room_at, room_order, visible_rooms
from ucon.sim.render.shapes import INDEX, MOST_CORNERS, MOST_SIDES

NEAR_M = 0.05
_NEAR = np.float32(NEAR_M)
_HALF = np.float32(0.5)
_ZERO = np.float32(0.0)
_ONE = np.float32(1.0)
_SLACK = np.float32(-1e-4)
"""Boxes are culled when they lie this far (m) outside, which bears the rounding of the planes."""

PAD_PX = np.uint64(32)
"""Spans are drawn in whole blocks of this many pixels, masked at the end, which compile to vector instructions."""

CAMERA_FIELDS = ("x", "y", "z", "cos_yaw", "sin_yaw", "cos_pitch", "sin_pitch", "tan_half", "sample_x", "sample_y")


@leaf
def camera_frame(camera: F64, frame: F32) -> None:
    """Rows of ``frame`` (4, 3): right, up, forward, position."""
    c, s, cp, sp = camera[3], camera[4], camera[5], camera[6]
    frame[0, 0], frame[0, 1], frame[0, 2] = s, -c, 0.0
    frame[1, 0], frame[1, 1], frame[1, 2] = -c * sp, -s * sp, cp
    frame[2, 0], frame[2, 1], frame[2, 2] = c * cp, s * cp, sp
    frame[3, 0], frame[3, 1], frame[3, 2] = camera[0], camera[1], camera[2]


@leaf
def _frustum(frame: F32, view: Any, window: F64, planes: F32) -> None:
    """Inward normals of near, left, right, top and bottom of a rectangle of the picture, all through the camera."""
    left, right = np.float32((window[0] - view[3]) / view[2]), np.float32((window[2] - view[3]) / view[2])
    top, bottom = np.float32((view[4] - window[1]) / view[2]), np.float32((view[4] - window[3]) / view[2])
    for k in range(3):
        planes[0, k] = frame[2, k]
        planes[1, k] = frame[0, k] - left * frame[2, k]
        planes[2, k] = right * frame[2, k] - frame[0, k]
        planes[3, k] = top * frame[2, k] - frame[1, k]
        planes[4, k] = frame[1, k] - bottom * frame[2, k]


@leaf
def _outside(boxes: F32, i: int, planes: F32, frame: F32) -> bool:
    """Whether a box lies wholly behind one of the planes."""
    x0, y0, z0 = boxes[i, 0] - frame[3, 0], boxes[i, 1] - frame[3, 1], boxes[i, 2] - frame[3, 2]
    x1, y1, z1 = boxes[i, 3] - frame[3, 0], boxes[i, 4] - frame[3, 1], boxes[i, 5] - frame[3, 2]
    for k in range(5):
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
    cull: bool,
    size: tuple[int, int],
    inverse_depth: F32,
    faces: I32,
) -> None:
    """Fill ``inverse_depth`` and ``faces`` (H * W + PAD_PX) row by row; 0 and -1 where there is nothing.

    Without ``cull`` every part is drawn, which must give the same picture.
    """
    width, height = size
    inverse_depth[:] = _ZERO
    faces[:] = -1
    frame = np.empty((4, 3), np.float32)
    camera_frame(camera, frame)
    scale = width * 0.5 / camera[7]
    view = (width, height, scale, width * 0.5 + 0.5 - camera[8], height * 0.5 + 0.5 - camera[9])
    windows = np.empty((rooms.shape[0], 4))
    windows[:, 0], windows[:, 1], windows[:, 2], windows[:, 3] = 0.0, 0.0, width, height
    own = room_at(rooms, camera[0], camera[1])
    if cull and own >= 0 and camera[2] < wall_height:
        visible_rooms(rooms, portals, frame, view, own, windows)
    order = np.empty(rooms.shape[0], np.int64)
    room_order(rooms, camera[0], camera[1], order)
    planes = np.empty((5, 3), np.float32)
    scratch = np.empty((7, max(MOST_CORNERS, 2 * MOST_SIDES, height)), np.float32)
    boxes = (tables.groups, tables.group_boxes, tables.part_boxes)
    geometry = (tables.vertices, tables.parts, tables.face_planes, tables.face_topology, frame, scratch)
    target = (inverse_depth, faces, width)
    for k in range(rooms.shape[0]):
        r = order[k]
        if windows[r, 0] >= windows[r, 2]:
            continue
        _frustum(frame, view, windows[r], planes)
        listed = (room_groups, room_start[r], room_start[r + 1])
        _draw_room(listed, boxes, planes, cull, geometry, view, windows[r], target)


@leaf
def _draw_room(
    listed: Any, boxes: Any, planes: F32, cull: bool, geometry: Any, view: Any, bounds: F64, target: Any
) -> None:
    """Draw what touches a room, inside the rectangle of the picture in which the room can be seen."""
    groups, group_boxes, part_boxes = boxes
    frame = geometry[4]
    x0, x1 = max(0, int(bounds[0])), min(view[0], int(bounds[2]) + 1)
    y0, y1 = max(0, int(bounds[1])), min(view[1], int(bounds[3]) + 1)
    window = (np.int32(x0), np.int32(y0), np.int32(x1), np.int32(y1))
    for i in range(listed[1], listed[2]):
        g = listed[0][i]
        if cull and _outside(group_boxes, g, planes, frame):
            continue
        first = groups[g, 0]
        for p in range(first, first + groups[g, 1]):
            if not cull or not _outside(part_boxes, p, planes, frame):
                _draw_part(p, geometry, view, window, target)


@leaf
def _draw_part(p: int, geometry: Any, view: Any, window: Any, target: Any) -> None:
    """Project the corners of a part and draw those of its faces that look at the camera."""
    scale, middle_x, middle_y = np.float32(view[2]), np.float32(view[3]), np.float32(view[4])
    vertices, parts, face_planes, face_topology, frame, scratch = geometry
    cx, cy, cz = frame[3, 0], frame[3, 1], frame[3, 2]
    rx, ry = frame[0, 0], frame[0, 1]
    ux, uy, uz = frame[1, 0], frame[1, 1], frame[1, 2]
    fx, fy, fz = frame[2, 0], frame[2, 1], frame[2, 2]
    first, corners = parts[p, 0], parts[p, 1]
    nearest = np.float32(1e9)
    for i in range(corners):
        dx, dy, dz = vertices[first + i, 0] - cx, vertices[first + i, 1] - cy, vertices[first + i, 2] - cz
        scratch[0, i] = dx * rx + dy * ry
        scratch[1, i] = dx * ux + dy * uy + dz * uz
        scratch[2, i] = dx * fx + dy * fy + dz * fz
        nearest = min(nearest, scratch[2, i])
    whole = nearest >= _NEAR
    if whole:
        left, right, top, bottom = np.float32(1e9), np.float32(-1e9), np.float32(1e9), np.float32(-1e9)
        for i in range(corners):
            inverse = scale / scratch[2, i]
            scratch[0, i] = middle_x + scratch[0, i] * inverse
            scratch[1, i] = middle_y - scratch[1, i] * inverse
            left, right = min(left, scratch[0, i]), max(right, scratch[0, i])
            top, bottom = min(top, scratch[1, i]), max(bottom, scratch[1, i])
        if max(_first(left), window[0]) >= _last(right, window[2]):
            return
        if max(_first(top), window[1]) >= _last(bottom, window[3]):
            return
    step = _ONE / scale
    for f in range(parts[p, 2], parts[p, 2] + parts[p, 3]):
        nx, ny, nz = face_planes[f, 0], face_planes[f, 1], face_planes[f, 2]
        distance = face_planes[f, 3] - (nx * cx + ny * cy + nz * cz)
        if distance >= np.float32(-1e-6):
            continue
        start, corners = face_topology[f, 0], face_topology[f, 1]
        if whole:
            for k in range(corners):
                j = INDEX[start + k]
                scratch[3, k], scratch[4, k] = scratch[0, j], scratch[1, j]
        else:
            corners = _clip_near(start, corners, scratch, scale, middle_x, middle_y)
        over = _ONE / distance
        a = (nx * rx + ny * ry) * step * over
        b = -(nx * ux + ny * uy + nz * uz) * step * over
        c = (nx * fx + ny * fy + nz * fz) * over + a * (_HALF - middle_x) + b * (_HALF - middle_y)
        _fill(f, corners, a, b, c, window, scratch, target)


@leaf
def _clip_near(start: int, corners: int, scratch: F32, scale: float, middle_x: float, middle_y: float) -> int:
    """Cut a face at the near plane and project what is left; returns its corners."""
    m = 0
    for k in range(corners):
        i, j = INDEX[start + k], INDEX[start + (k + 1 if k + 1 < corners else 0)]
        if scratch[2, i] >= _NEAR:
            inverse = scale / scratch[2, i]
            scratch[3, m], scratch[4, m] = middle_x + scratch[0, i] * inverse, middle_y - scratch[1, i] * inverse
            m += 1
        if (scratch[2, i] >= _NEAR) != (scratch[2, j] >= _NEAR):
            t = (_NEAR - scratch[2, i]) / (scratch[2, j] - scratch[2, i])
            inverse = scale / _NEAR
            scratch[3, m] = middle_x + (scratch[0, i] + t * (scratch[0, j] - scratch[0, i])) * inverse
            scratch[4, m] = middle_y - (scratch[1, i] + t * (scratch[1, j] - scratch[1, i])) * inverse
            m += 1
    return m


@leaf
def _first(position: float) -> int:
    """First pixel whose centre lies beyond ``position``, not below 0."""
    return np.int32(max(position, -_HALF) + _HALF)


@leaf
def _last(position: float, size: int) -> int:
    """One past the last pixel whose centre lies before ``position``, at most ``size``."""
    return np.int32(min(max(position, -_HALF), np.float32(size)) + _HALF)


@leaf
def _fill(f: int, m: int, a: float, b: float, c: float, window: Any, scratch: F32, target: Any) -> None:
    """Scan-convert a convex polygon with m corners and the depth plane ``a x + b y + c``.

    Corners run counter-clockwise, so edges that go down the picture bound it on the left.
    """
    top, bottom = np.float32(1e9), np.float32(-1e9)
    for k in range(m):
        top, bottom = min(top, scratch[4, k]), max(bottom, scratch[4, k])
    y0, y1 = max(_first(top), window[1]), _last(bottom, window[3])
    if m < 3 or y0 >= y1:
        return
    for k in range(m):
        n = k + 1 if k + 1 < m else 0
        if scratch[4, k] < scratch[4, n]:
            _edge(scratch[3, k], scratch[4, k], scratch[3, n], scratch[4, n], scratch, 5, y0, y1)
        elif scratch[4, k] > scratch[4, n]:
            _edge(scratch[3, n], scratch[4, n], scratch[3, k], scratch[4, k], scratch, 6, y0, y1)
    depths, faces, width = target
    face = np.int32(f)
    for y in range(y0, y1):
        x0, x1 = max(_first(scratch[5, y]), window[0]), _last(scratch[6, y], window[2])
        if x0 >= x1:
            continue
        row_z = c + b * np.float32(y)
        begin = np.uint64(y * width)
        end = np.uint64(x1)
        for start in range(np.uint64(x0), end, PAD_PX):
            for k in range(PAD_PX):
                x = start + np.uint64(k)
                i = begin + x
                z = row_z + a * np.float32(np.int32(x))
                nearer = ((z > depths[i]) | ((z == depths[i]) & (face < faces[i]))) & (x < end)
                depths[i] = z if nearer else depths[i]
                faces[i] = face if nearer else faces[i]


@leaf
def _edge(x_top: float, y_top: float, x_low: float, y_low: float, bounds: F32, side: int, y0: int, y1: int) -> None:
    """Where an edge crosses the centre of each row."""
    start, end = max(_first(y_top), y0), _last(y_low, y1)
    slope = (x_low - x_top) / (y_low - y_top)
    for y in range(np.uint64(start), np.uint64(max(start, end))):
        bounds[side, y] = x_top + (np.float32(np.int32(y)) + _HALF - y_top) * slope
