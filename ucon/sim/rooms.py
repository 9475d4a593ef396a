"""Which room every node of a home's grid is in, by the rooms' rectangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.scenes.spec import GRID_M, HomeSpec


def room_grid(spec: HomeSpec) -> tuple[tuple[float, float], NDArray[np.int16]]:
    """Origin of the grid and room of every cell.

    Returns:
        Corner of cell (0, 0) in world metres, and (nx, ny) int16 room numbers, -1 outside all rooms.
    """
    rects = np.array([room.rect for room in spec.rooms])
    origin = (float(rects[:, 0].min()), float(rects[:, 1].min()))
    nx, ny = np.rint((rects[:, 2:].max(axis=0) - origin) / GRID_M).astype(int)
    rooms = np.full((nx, ny), -1, np.int16)
    for number, rect in enumerate(rects):
        i0, j0, i1, j1 = np.rint((rect - (*origin, *origin)) / GRID_M).astype(int)
        rooms[i0:i1, j0:j1] = number
    return origin, rooms
