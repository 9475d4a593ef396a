"""Which rooms can be seen, and within which horizontal angles.

Rooms are convex cells, openings are portals between them. From the camera's room its horizontal field of view is
clipped through every opening that it meets; rooms never reached are not drawn, the others carry the clipped angles
as two more culling planes. The opening is taken on the grid line, in the middle of the wall: a ray that crosses it
anywhere else is stopped by a wall box, so the test never loses a pixel, whatever the thickness of the wall.
"""

from __future__ import annotations

import math

import numpy as np

from ucon.sim.render.kernels import F32, F64, jit

_MARGIN_RAD = 1e-5
_DOORWAY_M = 0.1
"""Nearer than this to an opening, everything behind it may be seen."""


@jit
def room_at(rooms: F32, x: float, y: float) -> int:
    """Room whose rectangle contains a point, -1 outside of all."""
    for r in range(rooms.shape[0]):
        if rooms[r, 0] <= x <= rooms[r, 2] and rooms[r, 1] <= y <= rooms[r, 3]:
            return r
    return -1


@jit
def half_angle(cos_pitch: float, sin_pitch: float, tan_x: float, tan_y: float) -> float:
    """Half the horizontal angle that a view covers; the full circle where it reaches the zenith or nadir."""
    ahead = cos_pitch - tan_y * abs(sin_pitch)
    return math.pi if ahead <= 1e-3 else math.atan(tan_x / ahead)


@jit
def visible_rooms(
    rooms: F32, portals: F64, x: float, y: float, yaw: float, room: int, half: float, low: F64, high: F64
) -> None:
    """Angles relative to ``yaw`` under which each room may be seen, (nr,) each; ``low > high`` where it cannot.

    A room that is reached again under more angles is searched again with all of them, so the angles only grow and
    the search ends.
    """
    low[:], high[:] = 1.0, -1.0
    queued = np.zeros(rooms.shape[0], np.bool_)
    low[room], high[room] = -half, half
    queued[room] = True
    pending = True
    while pending:
        pending = False
        for r in range(rooms.shape[0]):
            if not queued[r]:
                continue
            queued[r] = False
            for d in range(portals.shape[0]):
                a, b = int(portals[d, 4]), int(portals[d, 5])
                if r != a and r != b:
                    continue
                beyond = b if r == a else a
                if beyond != room and _pass_portal(rooms, portals[d], x, y, yaw, r, beyond, low, high):
                    queued[beyond] = True
                    pending = True


@jit
def _pass_portal(
    rooms: F32, portal: F64, x: float, y: float, yaw: float, r: int, beyond: int, low: F64, high: F64
) -> bool:
    """Clip the angles of room ``r`` by an opening and add them to the room beyond; whether those grew."""
    axis, coord, start, end = int(portal[0]), portal[1], portal[2], portal[3]
    along, across = (y, x) if axis == 0 else (x, y)
    if abs(across - coord) < _DOORWAY_M and start - _DOORWAY_M <= along <= end + _DOORWAY_M:
        return _widen(beyond, low[r], high[r], low, high)
    middle = 0.5 * (rooms[beyond, axis] + rooms[beyond, axis + 2])
    if (middle > coord) != (across < coord):
        return False
    if axis == 0:
        first = _turn(math.atan2(start - y, coord - x) - yaw)
        last = _turn(math.atan2(end - y, coord - x) - yaw)
    else:
        first = _turn(math.atan2(coord - y, start - x) - yaw)
        last = _turn(math.atan2(coord - y, end - x) - yaw)
    left, right = min(first, last) - _MARGIN_RAD, max(first, last) + _MARGIN_RAD
    if right - left <= math.pi:
        return _widen(beyond, max(low[r], left), min(high[r], right), low, high)
    behind_right = _widen(beyond, max(low[r], right - 2 * _MARGIN_RAD), high[r], low, high)
    behind_left = _widen(beyond, low[r], min(high[r], left + 2 * _MARGIN_RAD), low, high)
    return behind_right or behind_left


@jit
def _widen(room: int, left: float, right: float, low: F64, high: F64) -> bool:
    if left >= right:
        return False
    if low[room] > high[room]:
        low[room], high[room] = left, right
        return True
    grown = left < low[room] or right > high[room]
    low[room], high[room] = min(low[room], left), max(high[room], right)
    return grown


@jit
def _turn(angle: float) -> float:
    """The same angle within half a turn of zero."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


@jit
def room_order(rooms: F32, x: float, y: float, order: np.ndarray) -> None:
    """Room numbers from the nearest to the farthest, ties by number."""
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
