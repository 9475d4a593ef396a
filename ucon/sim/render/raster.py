"""The visibility buffer: for each pixel the nearest face, and one over its depth.

Faces are scan-converted into spans. Where two faces are equally near, the one with the lower number wins. So the image
does not depend on the order of drawing, and skipping what is not visible changes no pixel.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I32, inlined, jit, leaf
from ucon.sim.render.parts import draw_part, new_scratch
from ucon.sim.render.portals import room_at, room_order, visible_rooms

_ZERO = np.float32(0.0)
_SLACK = np.float32(-1e-4)
"""Boxes are culled if they are outside by this much, metres, which covers the rounding of the planes."""

CAMERA_FIELDS = ("x", "y", "z", "cos_yaw", "sin_yaw", "cos_pitch", "sin_pitch", "tan_half", "sample_x", "sample_y")


@leaf
def camera_frame(camera: F64, frame: F32) -> None:
    """Write the camera's axes and position to ``frame`` (4, 3): right, up, forward, position.

    Args:
        camera: (10,) float64, in the order of :data:`CAMERA_FIELDS`.
        frame: (4, 3) float32, written.
    """
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


@inlined
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
    """Compute the visibility buffer.

    Args:
        camera: (10,) float64, in the order of :data:`CAMERA_FIELDS`.
        tables: polygons, see :class:`ucon.sim.render.tables.Tables`.
        rooms: (nr, 4) rectangles, metres.
        portals: (n, 7), see :class:`ucon.sim.render.arena.Arena`.
        wall_height: metres.
        room_start: see ``Arena``.
        room_groups: see ``Arena``.
        cull: skip what is not visible; the result is the same without.
        size: width and height, pixels.
        inverse_depth: (H * W + BLOCK_PX,) float32, written row by row: 1 / m, 0 where there is nothing.
        faces: (H * W + BLOCK_PX,) int32, written: number of the face, -1 where there is nothing.
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
    boxes = (tables.groups, tables.group_boxes, tables.part_boxes)
    geometry = (tables.vertices, tables.parts, tables.face_planes, tables.face_topology, frame, new_scratch())
    target = (inverse_depth, faces, width)
    for k in range(rooms.shape[0]):
        r = order[k]
        if windows[r, 0] >= windows[r, 2]:
            continue
        _frustum(frame, view, windows[r], planes)
        listed = (room_groups, room_start[r], room_start[r + 1])
        _draw_room(listed, boxes, planes, cull, geometry, view, windows[r], target)


@inlined
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
                draw_part(p, geometry, view, window, target)
