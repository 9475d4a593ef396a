"""The 5 cm map of L3MVN: obstacles, explored space and visited cells, from depth and poses alone.

It has the frame and the centre of the 0.25 m map and covers all of it (64 m; no home here is longer than 29 m). L3MVN
keeps 48 m around the start, which the longest homes here would leave, and works in a window of 24 m around the agent.
Its frontiers lie within 5 m of the agent, so the window makes no difference.
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
#: Cell number of the start, in a and b.
FINE_HALF = HALF * PER_CELL + PER_CELL // 2
_ROOM = 1 << 16
"""Size of the working memory; more cells than one frame can touch."""

#: (a, b).
Cell = tuple[int, int]
#: (a0, a1, b0, b1), ends excluded.
Box = tuple[int, int, int, int]


class FineMap:
    """Everything one agent has seen in one episode, in cells of 5 cm; allocated once, 2 MB.

    A cell is an obstacle if a point of any frame in it was 0.25 m high or more, up to 0.5 m above the camera. A later
    level frame that shows only lower points, there and around, takes that back. A cell is explored if a point of -0.4
    to 2 m was in it (floor points: within 4.5 m), or if a sight line passed over it within 4.5 m ahead, below the top
    of what counts as an obstacle.

    L3MVN uses points alone. A camera 1.25 m high does not see the nearest floor in a level view, and its rows of floor
    points are 5 cm apart at 2 m and 25 cm apart at 4.5 m, which a 5 x 5 closing just bridges. Points alone would give a
    frontier around the robot's own feet and a ragged one far away. Neighbouring points of a wall are joined.

    Attributes:
        body: the agent's camera.
        cells: (1285, 1285) uint8 bits OBSTACLE, EXPLORED, VISITED, indexed [a, b] = [x, y].
        view: the agent's pose at the last update.
    """

    def __init__(self, body: Body = PAPER_BODY) -> None:
        """Start with an empty map.

        Args:
            body: the agent's camera; that of the paper's rules by default.
        """
        self.body = body
        self.cells = np.zeros((FINE_SIZE, FINE_SIZE), np.uint8)
        self._bounds = np.zeros(4, np.int32)
        self._touched = np.zeros(_ROOM, np.int32)
        self._reach = np.zeros(kernels.BINS, np.float64)
        self.view = View(HALF, HALF, 0)
        self._unbound()

    def _unbound(self) -> None:
        """Set the bounds to "nothing marked"."""
        self._bounds[:] = FINE_SIZE, -1, FINE_SIZE, -1

    def reset(self) -> None:
        """Start an episode: clear what was marked."""
        a0, a1, b0, b1 = self.extent()
        self.cells[a0:a1, b0:b1] = 0
        self.view = View(HALF, HALF, 0)
        self._unbound()

    def update(self, view: View, depth: NDArray[np.float32]) -> None:
        """Add one frame.

        Args:
            view: the agent's pose.
            depth: (H, W) float32, metres along the optical axis (:func:`frame_depth`).
        """
        self.view = view
        camera = camera_of(view, depth, self.body)
        kernels.add_frame(depth, camera, FINE_HALF, self.cells, self._bounds, self._touched, self._reach)
        self._visit(*cell_of(view.xy))

    def _visit(self, a: int, b: int) -> None:
        """Mark the 3 x 3 cells around the agent as explored and visited, as L3MVN does."""
        a, b = min(max(a, 1), FINE_SIZE - 2), min(max(b, 1), FINE_SIZE - 2)
        self.cells[a - 1 : a + 2, b - 1 : b + 2] |= EXPLORED | VISITED
        low, high = self._bounds[::2], self._bounds[1::2]
        np.minimum(low, (a - 1, b - 1), out=low)
        np.maximum(high, (a + 1, b + 1), out=high)

    def extent(self, margin: int = 0) -> Box:
        """The smallest box of cells that holds everything marked, grown by ``margin`` cells and clipped to the map.

        Returns:
            (a0, a1, b0, b1), ends excluded.
        """
        a0, a1, b0, b1 = (int(v) for v in self._bounds)
        if a1 < a0:
            return FINE_HALF, FINE_HALF + 1, FINE_HALF, FINE_HALF + 1
        low, high = max(a0 - margin, 0), min(a1 + 1 + margin, FINE_SIZE)
        return low, high, max(b0 - margin, 0), min(b1 + 1 + margin, FINE_SIZE)

    def layer(self, bit: int, box: Box | None = None) -> NDArray[np.uint8]:
        """One layer of the map as 0 and 1.

        Args:
            bit: OBSTACLE, EXPLORED or VISITED.
            box: cells (a0, a1, b0, b1), ends excluded; all by default.

        Returns:
            (a1 - a0, b1 - b0) uint8.
        """
        a0, a1, b0, b1 = box or (0, FINE_SIZE, 0, FINE_SIZE)
        return ((self.cells[a0:a1, b0:b1] & bit) > 0).view(np.uint8)

    @property
    def obstacle(self) -> NDArray[np.uint8]:
        """(1285, 1285) uint8, 1 where there is an obstacle."""
        return self.layer(OBSTACLE)

    @property
    def explored(self) -> NDArray[np.uint8]:
        """(1285, 1285) uint8, 1 where the cell is explored."""
        return self.layer(EXPLORED)

    @property
    def visited(self) -> NDArray[np.uint8]:
        """(1285, 1285) uint8, 1 where the agent stood."""
        return self.layer(VISITED)

    @property
    def nbytes(self) -> int:
        """Memory of all arrays in bytes."""
        arrays: tuple[NDArray[Any], ...] = (self.cells, self._bounds, self._touched, self._reach)
        return sum(array.nbytes for array in arrays)


def cell_of(xy: tuple[float, float]) -> Cell:
    """The cell (a, b) that holds a point (x, y) in metres in the start frame."""
    return int(np.floor(xy[0] / FINE_M + 0.5)) + FINE_HALF, int(np.floor(xy[1] / FINE_M + 0.5)) + FINE_HALF


def middle_of(a: int, b: int) -> tuple[float, float]:
    """Centre of a cell, in metres in the start frame."""
    return (a - FINE_HALF) * FINE_M, (b - FINE_HALF) * FINE_M
