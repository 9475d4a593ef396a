"""The 5 cm map of L3MVN: obstacles, explored space and the cells visited, from depth and poses alone.

It shares frame and middle with the 0.25 m map and covers all of it (64 m; none of our homes is more than 29 m long).
L3MVN keeps 48 m around the start, which our longest homes would leave, and works in a window of 24 m around the agent;
its frontiers lie within 5 m of the agent, so nothing here depends on a window.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.perception.mapping import fine_kernels as kernels
from ucon.perception.mapping.body import PAPER_BODY, Body
from ucon.perception.mapping.fine_kernels import EXPLORED, FINE_M, OBSTACLE, PER_CELL, VISITED
from ucon.perception.mapping.semantic_map import HALF, SIZE, View, camera_of

FINE_SIZE = SIZE * PER_CELL
#: The cell whose middle is the start.
FINE_HALF = HALF * PER_CELL + PER_CELL // 2
_ROOM = 1 << 16
"""More cells than one frame can touch: 5 m to either side, 14 m from the nearest point to the farthest."""

Cell = tuple[int, int]
Box = tuple[int, int, int, int]


class FineMap:
    """Everything one agent has seen in one episode, in cells of 5 cm; allocated once, 2 MB.

    A cell is an obstacle if a point of any frame in it was 0.25 m high or more, up to 0.5 m above the camera. A later
    level frame that shows lower points only, there and around, takes that back. It is explored if a point of -0.4 to
    2 m was in it (of the floor, within 4.5 m), or a sight line passed over it, below what counts as an obstacle's top
    and within 4.5 m ahead. L3MVN uses points alone. From 1.25 m high the floor nearer than that is out of a level
    view, and its rows are 5 cm apart 2 m away, 25 cm at 4.5 m, where a 5 x 5 closing just bridges them: points alone
    would give an edge around the robot's own feet and a ragged one far away. Neighbouring points of a wall are joined.

    Attributes:
        body: what the agent knows of its own camera.
        cells: (1285, 1285) uint8 bits OBSTACLE, EXPLORED, VISITED, indexed [a, b] = [x, y].
    """

    def __init__(self, body: Body = PAPER_BODY) -> None:
        self.body = body
        self.cells = np.zeros((FINE_SIZE, FINE_SIZE), np.uint8)
        self._bounds = np.zeros(4, np.int32)
        self._touched = np.zeros(_ROOM, np.int32)
        self._reach = np.zeros(kernels.BINS, np.float64)
        self.view = View(HALF, HALF, 0)
        self._unbound()

    def _unbound(self) -> None:
        self._bounds[:] = FINE_SIZE, -1, FINE_SIZE, -1

    def reset(self) -> None:
        """Forget the episode; clears what was marked only."""
        a0, a1, b0, b1 = self.extent()
        self.cells[a0:a1, b0:b1] = 0
        self.view = View(HALF, HALF, 0)
        self._unbound()

    def update(self, view: View, depth: NDArray[np.float32]) -> None:
        """Add one frame: where the agent is and depth (H, W) in optical metres (``frame_depth``)."""
        self.view = view
        camera = camera_of(view, depth, self.body)
        kernels.add_frame(depth, camera, FINE_HALF, self.cells, self._bounds, self._touched, self._reach)
        self._visit(*cell_of(view.xy))

    def _visit(self, a: int, b: int) -> None:
        """Mark 3 x 3 cells, as L3MVN does."""
        a, b = min(max(a, 1), FINE_SIZE - 2), min(max(b, 1), FINE_SIZE - 2)
        self.cells[a - 1 : a + 2, b - 1 : b + 2] |= EXPLORED | VISITED
        low, high = self._bounds[::2], self._bounds[1::2]
        np.minimum(low, (a - 1, b - 1), out=low)
        np.maximum(high, (a + 1, b + 1), out=high)

    def extent(self, margin: int = 0) -> Box:
        """Cells (a0, a1, b0, b1), ends excluded, that hold all that was marked, grown by ``margin``."""
        a0, a1, b0, b1 = (int(v) for v in self._bounds)
        if a1 < a0:
            return FINE_HALF, FINE_HALF + 1, FINE_HALF, FINE_HALF + 1
        low, high = max(a0 - margin, 0), min(a1 + 1 + margin, FINE_SIZE)
        return low, high, max(b0 - margin, 0), min(b1 + 1 + margin, FINE_SIZE)

    def layer(self, bit: int, box: Box | None = None) -> NDArray[np.uint8]:
        """0 or 1 for each cell (of a box), uint8: one of OBSTACLE, EXPLORED, VISITED."""
        a0, a1, b0, b1 = box or (0, FINE_SIZE, 0, FINE_SIZE)
        return ((self.cells[a0:a1, b0:b1] & bit) > 0).view(np.uint8)

    @property
    def obstacle(self) -> NDArray[np.uint8]:
        """(1285, 1285) uint8."""
        return self.layer(OBSTACLE)

    @property
    def explored(self) -> NDArray[np.uint8]:
        """(1285, 1285) uint8."""
        return self.layer(EXPLORED)

    @property
    def visited(self) -> NDArray[np.uint8]:
        """(1285, 1285) uint8."""
        return self.layer(VISITED)

    @property
    def nbytes(self) -> int:
        """Memory of all arrays, bytes."""
        arrays: tuple[NDArray[Any], ...] = (self.cells, self._bounds, self._touched, self._reach)
        return sum(array.nbytes for array in arrays)


def cell_of(xy: tuple[float, float]) -> Cell:
    """The cell that holds a point (metres from the start)."""
    return int(np.floor(xy[0] / FINE_M + 0.5)) + FINE_HALF, int(np.floor(xy[1] / FINE_M + 0.5)) + FINE_HALF


def middle_of(a: int, b: int) -> tuple[float, float]:
    """Metres from the start to the middle of a cell."""
    return (a - FINE_HALF) * FINE_M, (b - FINE_HALF) * FINE_M
