"""Which rooms are visible, and in which rectangle of the image.

Rooms are convex cells, openings are portals between them. The image from the camera's room is clipped to the projection
of every opening in view. Rooms never reached are not drawn, and nothing of a room is drawn outside its rectangle. The
opening is taken at the middle of the wall: a ray that crosses the grid line elsewhere is stopped by a wall box, so no
pixel is lost, whatever the thickness of the wall.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, jit, leaf

_MARGIN_PX = 0.05
_MARGIN_M = 1e-4
_DOORWAY_M = 0.1
"""Nearer than this to an opening, the whole image may show what is behind it. Metres."""
_AHEAD_M = 1e-3
"""Portals are clipped at this distance in front of the camera before projection. Metres."""


@leaf
def room_at(rooms: F32, x: float, y: float) -> int:
    """Number of the room whose rectangle contains a point, -1 outside all rooms.

    Args:
        rooms: (nr, 4) rectangles, metres.
        x: world metres.
        y: world metres.
    """
    for r in range(rooms.shape[0]):
        if rooms[r, 0] <= x <= rooms[r, 2] and rooms[r, 1] <= y <= rooms[r, 3]:
            return r
    return -1


@jit
def visible_rooms(rooms: F32, portals: F64, frame: F32, view: Any, own: int, windows: F64) -> None:
    """Compute the rectangle of the image in which each room is visible.

    A room seen through several openings gets the rectangle around all of them and is searched again. Rectangles only
    grow, so the search ends.

    Args:
        rooms: (nr, 4) rectangles, metres.
        portals: (n, 7) axis, coord, lo, hi, room a, room b, height.
        frame: (4, 3) of :func:`ucon.sim.render.raster.camera_frame`.
        view: image size and projection.
        own: the camera's room, -1 for none.
        windows: (nr, 4) float64, written: left, top, right, bottom in pixels; left >= right where a room is not
            visible.
    """
    windows[:, 0], windows[:, 2] = 1.0, 0.0
    windows[own, 0], windows[own, 1] = 0.0, 0.0
    windows[own, 2], windows[own, 3] = view[0], view[1]
    queued = np.zeros(rooms.shape[0], np.bool_)
    queued[own] = True
    corners, seen = np.empty((4, 3)), np.empty(4)
    pending = True
    while pending:
        pending = False
        for r in range(rooms.shape[0]):
            if not queued[r]:
                continue
            queued[r] = False
            for d in range(portals.shape[0]):
                a, b = int(portals[d, 4]), int(portals[d, 5])
                beyond = b if r == a else a
                if (r != a and r != b) or beyond == own:
                    continue
                if _through(rooms, portals[d], frame, view, beyond, corners, seen):
                    _clip(windows[r], seen)
                    if _grow(windows[beyond], seen):
                        queued[beyond] = True
                        pending = True


@leaf
def _through(rooms: F32, portal: F64, frame: F32, view: Any, beyond: int, corners: F64, seen: F64) -> bool:
    """Write the rectangle in which an opening appears to ``seen``; False where it is not visible from this side."""
    axis = int(portal[0])
    across, along = frame[3, axis], frame[3, 1 - axis]
    if abs(across - portal[1]) < _DOORWAY_M and portal[2] - _DOORWAY_M <= along <= portal[3] + _DOORWAY_M:
        seen[0], seen[1], seen[2], seen[3] = 0.0, 0.0, view[0], view[1]
        return True
    middle = 0.5 * (rooms[beyond, axis] + rooms[beyond, axis + 2])
    if (middle > portal[1]) != (across < portal[1]):
        return False
    for k in range(4):
        place = portal[2] - _MARGIN_M if k < 2 else portal[3] + _MARGIN_M
        up = -_MARGIN_M if k == 0 or k == 3 else portal[6] + _MARGIN_M
        to_x = (portal[1] if axis == 0 else place) - frame[3, 0]
        to_y = (place if axis == 0 else portal[1]) - frame[3, 1]
        to_z = up - frame[3, 2]
        for j in range(3):
            corners[k, j] = to_x * frame[j, 0] + to_y * frame[j, 1] + to_z * frame[j, 2]
    return _project(corners, view, seen)


@leaf
def _project(corners: F64, view: Any, seen: F64) -> bool:
    """Bounds in the picture of a quadrilateral given by (right, up, ahead), cut in front of the camera."""
    seen[0], seen[1], seen[2], seen[3] = 1e9, 1e9, -1e9, -1e9
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]
        if a[2] >= _AHEAD_M:
            _include(a[0], a[1], a[2], view, seen)
        if (a[2] >= _AHEAD_M) != (b[2] >= _AHEAD_M):
            t = (_AHEAD_M - a[2]) / (b[2] - a[2])
            _include(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), _AHEAD_M, view, seen)
    return seen[0] <= seen[2]


@leaf
def _include(right: float, up: float, ahead: float, view: Any, seen: F64) -> None:
    x, y = view[3] + right * view[2] / ahead, view[4] - up * view[2] / ahead
    seen[0], seen[1] = min(seen[0], x - _MARGIN_PX), min(seen[1], y - _MARGIN_PX)
    seen[2], seen[3] = max(seen[2], x + _MARGIN_PX), max(seen[3], y + _MARGIN_PX)


@leaf
def _clip(window: F64, seen: F64) -> None:
    seen[0], seen[1] = max(seen[0], window[0]), max(seen[1], window[1])
    seen[2], seen[3] = min(seen[2], window[2]), min(seen[3], window[3])


@leaf
def _grow(window: F64, seen: F64) -> bool:
    """Widen a window by a rectangle; whether it grew."""
    if seen[0] >= seen[2] or seen[1] >= seen[3]:
        return False
    if window[0] >= window[2]:
        for k in range(4):
            window[k] = seen[k]
        return True
    grown = seen[0] < window[0] or seen[1] < window[1] or seen[2] > window[2] or seen[3] > window[3]
    window[0], window[1] = min(window[0], seen[0]), min(window[1], seen[1])
    window[2], window[3] = max(window[2], seen[2]), max(window[3], seen[3])
    return grown


@jit
def room_order(rooms: F32, x: float, y: float, order: np.ndarray) -> None:
    """Write the room numbers to ``order`` (nr,), from the nearest to the farthest; ties by number."""
    distance = np.empty(rooms.shape[0])
    for r in range(rooms.shape[0]):
        dx = max(rooms[r, 0] - x, 0.0, x - rooms[r, 2])
        dy = max(rooms[r, 1] - y, 0.0, y - rooms[r, 3])
        distance[r] = dx * dx + dy * dy
        k = r
        while k > 0 and distance[order[k - 1]] > distance[r]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = r
