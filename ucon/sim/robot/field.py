"""Lengths of the shortest paths of a disc, on a grid of 5 cm whose cells are each joined to 16 others.

A path on it is at most 2.7 % longer than the true one, plus at most a cell's side at each end. A cell is passable if a
disc with a radius smaller by 1.5 cm fits at its centre, so that no gap that the disc can pass is closed.
"""

from __future__ import annotations

import heapq
import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import F64, Flags, jit
from ucon.core.sharing import Shared
from ucon.sim.robot.floor import Floor
from ucon.sim.robot.floor_kernels import FloorTables, polygon_distance

CELL_M: Final = 0.05
SLACK_M: Final = 0.015
#: Paths begin and end within this many cells of a point: its own may be impassable where the disc touches something.
_AROUND: Final = 2
#: The 16 neighbours, (di, dj).
_STEPS: Final = np.array(
    [(a, b) for a in range(-2, 3) for b in range(-2, 3) if sorted((abs(a), abs(b))) in ([0, 1], [1, 1], [1, 2])]
)


class PathGrid(Shared):
    """Where the centre of a robot can be.

    Attributes:
        origin: (2,) corner of cell (0, 0), world metres.
        passable: (nx, ny) bool.
    """

    def __init__(self, floor: Floor) -> None:
        """Rasterise a floor."""
        self.origin = floor.low
        shape = np.ceil((floor.high - floor.low) / CELL_M).astype(int)
        self.passable = np.ones(tuple(shape), bool)
        _block(floor.tables, floor.radius_m - SLACK_M, self.origin, self.passable)

    def field(self, x: float, y: float, most_m: float = math.inf) -> Field:
        """Shortest paths from a point.

        Args:
            x: world metres.
            y: world metres.
            most_m: longer paths are not searched for.
        """
        return Field(self, _flood(self.passable, self.origin, x, y, most_m))

    def cell(self, xy: NDArray[np.float64]) -> NDArray[np.int64]:
        """(2,) the cell of a point (2,), which may be outside the grid."""
        return np.floor((xy - self.origin) / CELL_M).astype(np.int64)

    def centres(self, cells: NDArray[np.integer]) -> NDArray[np.float64]:
        """(n, 2) world metres of cells (n, 2)."""
        return self.origin + (cells + 0.5) * CELL_M


class Field(Shared):
    """Path lengths from a point to everywhere.

    Attributes:
        grid: the grid.
        metres: (nx, ny) to each cell's centre; infinity where no path leads.
    """

    def __init__(self, grid: PathGrid, metres: NDArray[np.float64]) -> None:
        self.grid, self.metres = grid, metres

    def at(self, x: float, y: float) -> float:
        """Metres to a point; infinity where no path leads to it."""
        return float(_at(self.metres, self.grid.origin, x, y))


@jit
def _block(floor: FloorTables, radius: float, origin: F64, passable: Flags) -> None:
    """Clear the cells at whose centre a disc touches a footprint."""
    nx, ny = passable.shape
    for k in range(len(floor.rounding)):
        i0 = max(int((floor.boxes[k, 0] - radius - origin[0]) / CELL_M), 0)
        j0 = max(int((floor.boxes[k, 1] - radius - origin[1]) / CELL_M), 0)
        i1 = min(int((floor.boxes[k, 2] + radius - origin[0]) / CELL_M), nx - 1)
        j1 = min(int((floor.boxes[k, 3] + radius - origin[1]) / CELL_M), ny - 1)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                if passable[i, j]:
                    x, y = origin[0] + (i + 0.5) * CELL_M, origin[1] + (j + 0.5) * CELL_M
                    away = polygon_distance(x, y, floor.points, floor.first[k], floor.first[k + 1]) - floor.rounding[k]
                    if away < radius:
                        passable[i, j] = False


@jit
def _flood(passable: Flags, origin: F64, x: float, y: float, most_m: float) -> F64:
    """Dijkstra's algorithm from a point; see :meth:`PathGrid.field`."""
    nx, ny = passable.shape
    metres = np.full((nx, ny), np.inf)
    ci, cj = int((x - origin[0]) // CELL_M), int((y - origin[1]) // CELL_M)
    queue = [(0.0, ci, cj)]
    queue.pop()
    for i in range(max(ci - _AROUND, 0), min(ci + _AROUND + 1, nx)):
        for j in range(max(cj - _AROUND, 0), min(cj + _AROUND + 1, ny)):
            if passable[i, j]:
                metres[i, j] = math.hypot(origin[0] + (i + 0.5) * CELL_M - x, origin[1] + (j + 0.5) * CELL_M - y)
                heapq.heappush(queue, (metres[i, j], i, j))
    while len(queue):
        d, i, j = heapq.heappop(queue)
        if d > most_m:
            break
        if d > metres[i, j]:
            continue
        for n in range(len(_STEPS)):
            a, b = i + _STEPS[n, 0], j + _STEPS[n, 1]
            if 0 <= a < nx and 0 <= b < ny and passable[a, b]:
                there = d + CELL_M * math.hypot(_STEPS[n, 0], _STEPS[n, 1])
                if there < metres[a, b] - 1e-12:
                    metres[a, b] = there
                    heapq.heappush(queue, (there, a, b))
    return metres


@jit
def _at(metres: F64, origin: F64, x: float, y: float) -> float:
    """Metres to a point, by the cells around it."""
    nx, ny = metres.shape
    ci, cj = int((x - origin[0]) // CELL_M), int((y - origin[1]) // CELL_M)
    nearest = math.inf
    for i in range(max(ci - _AROUND, 0), min(ci + _AROUND + 1, nx)):
        for j in range(max(cj - _AROUND, 0), min(cj + _AROUND + 1, ny)):
            away = math.hypot(origin[0] + (i + 0.5) * CELL_M - x, origin[1] + (j + 0.5) * CELL_M - y)
            nearest = min(nearest, metres[i, j] + away)
    return nearest
