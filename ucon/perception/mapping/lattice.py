"""Paths of a robot with six headings: breadth-first over the triangular lattice of its moves, every action one step.

From where the robot stands, moves of 0.25 m at headings of 60 degrees lead to the nodes of a triangular lattice. Node
(a, b) is at ``here + 0.25 (a e0 + b e1)``, with e0 along heading 0 and e1 along heading 1. There is a little more than
one node for each cell of the 0.25 m map; a cell's cost is that of its cheapest node.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import DIRECTIONS, LATTICE_STEPS
from ucon.core.jit import I32, Flags, jit
from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.map_kernels import CELL_M
from ucon.perception.mapping.obstacle_kernels import cell as fine_cell

#: Nodes to each side of the robot, 32 m.
_SPAN = 128
_SIDE = 2 * _SPAN + 1
HEADINGS = 6


class Lattice(PartlyShared):
    """Working memory and results of one robot's searches; see :func:`search`."""

    _shared: ClassVar[frozenset[str]] = frozenset()

    def __init__(self, unreached: int) -> None:
        """Allocate the arrays.

        Args:
            unreached: number of steps that stands for no path.
        """
        shape = (_SIDE, _SIDE, HEADINGS)
        self.steps = np.full(shape, unreached, np.int32)
        self.moves = np.zeros(shape, np.int32)
        self.came = np.zeros(shape, np.int8)
        self.used: NDArray[np.int32] = np.zeros(0, np.int32)
        self.best = np.full((257, 257, HEADINGS), -1, np.int32)
        """The state, as a row of the flattened lattice, by which each cell and heading is reached first."""
        self._unreached = unreached

    def search(
        self, free: Flags, window: tuple[int, int, int, int], xy: tuple[float, float], heading: int, out: Any
    ) -> NDArray[np.int32]:
        """Find all paths from a pose.

        Args:
            free: (1285, 1285) bool by cell of 5 cm, where the robot's middle can be.
            window: cells (i0, i1, j0, j1) of the 0.25 m map that paths may pass, ends excluded.
            xy: of the robot, metres.
            heading: number of its heading.
            out: steps and moves (257, 257, 6) int32, written where there is a path.

        Returns:
            (n,) int32, the rows of the flattened ``out`` that were written.
        """
        self.steps.reshape(-1)[self.used] = self._unreached
        queue = np.empty(_SIDE * _SIDE * HEADINGS, np.int32)
        count = _search(free, window, xy, heading, self.steps, self.moves, self.came, queue, self._unreached)
        self.used = queue[:count].copy()
        cells = np.empty(count, np.int32)
        n = _by_cell(self.used, xy, self.steps, self.moves, out[0], out[1], self.best, cells)
        return cells[:n].copy()

    def backwards(self, i: int, j: int, heading: int) -> list[int]:
        """Actions of the path to a cell and heading, the last one first: 0 move, 1 left, 2 right."""
        state = int(self.best[i, j, heading])
        actions: list[int] = []
        came = self.came.reshape(-1)
        while (action := int(came[state])) >= 0:
            actions.append(action)
            node, h = divmod(state, HEADINGS)
            if action == 0:
                a, b = divmod(node, _SIDE)
                da, db = LATTICE_STEPS[h].tolist()
                node = (a - da) * _SIDE + b - db
            else:
                h = (h - (1 if action == 1 else -1)) % HEADINGS
            state = node * HEADINGS + h
        return actions


@jit
def _place(a: int, b: int, xy: tuple[float, float]) -> tuple[float, float]:
    """Position in metres of a node."""
    p, q = CELL_M * (a - _SPAN), CELL_M * (b - _SPAN)
    return (
        xy[0] + p * DIRECTIONS[6, 0, 0] + q * DIRECTIONS[6, 1, 0],
        xy[1] + p * DIRECTIONS[6, 0, 1] + q * DIRECTIONS[6, 1, 1],
    )


@jit
def _cell(x: float, y: float) -> tuple[int, int]:
    """The cell of the 0.25 m map that holds a point."""
    return int(np.floor(x / CELL_M + 0.5)) + 128, int(np.floor(y / CELL_M + 0.5)) + 128


@jit
def _search(
    free: Flags, window: tuple[int, int, int, int], xy: tuple[float, float], heading: int, steps: I32, moves: I32,
    came: Any, queue: I32, unreached: int,
) -> int:  # fmt: skip
    """Breadth-first search from the node in the middle; returns the number of states in ``queue``."""
    steps[_SPAN, _SPAN, heading], moves[_SPAN, _SPAN, heading], came[_SPAN, _SPAN, heading] = 0, 0, -1
    queue[0] = (_SPAN * _SIDE + _SPAN) * HEADINGS + heading
    head, tail = 0, 1
    while head < tail:
        state = queue[head]
        head += 1
        h, node = state % HEADINGS, state // HEADINGS
        a0, b0 = node // _SIDE, node % _SIDE
        for action in range(3):
            a, b, turned = a0, b0, h
            if action == 0:
                a, b = a0 + LATTICE_STEPS[h, 0], b0 + LATTICE_STEPS[h, 1]
                if not (0 <= a < _SIDE and 0 <= b < _SIDE):
                    continue
            else:
                turned = (h + (1 if action == 1 else HEADINGS - 1)) % HEADINGS
            if steps[a, b, turned] < unreached:
                continue
            if action == 0:
                x, y = _place(a, b, xy)
                i, j = _cell(x, y)
                if not (window[0] <= i < window[1] and window[2] <= j < window[3]) or not free[fine_cell(x, y)]:
                    continue
            steps[a, b, turned] = steps[a0, b0, h] + 1
            moves[a, b, turned] = moves[a0, b0, h] + (action == 0)
            came[a, b, turned] = action
            queue[tail] = (a * _SIDE + b) * HEADINGS + turned
            tail += 1
    return tail


@jit
def _by_cell(
    used: I32, xy: tuple[float, float], steps: I32, moves: I32, out_steps: I32, out_moves: I32, best: I32, cells: I32
) -> int:
    """Write steps, moves and state of the first node of every cell and heading; returns how many there are.

    ``used`` is in order of steps, so the first node is the cheapest; ``out_steps`` holds a larger value on entry.
    """
    count = 0
    for k in range(used.shape[0]):
        h, node = used[k] % HEADINGS, used[k] // HEADINGS
        a, b = node // _SIDE, node % _SIDE
        x, y = _place(a, b, xy)
        i, j = _cell(x, y)
        if out_steps[i, j, h] <= steps[a, b, h]:
            continue
        out_steps[i, j, h], out_moves[i, j, h], best[i, j, h] = steps[a, b, h], moves[a, b, h], used[k]
        cells[count] = (i * out_steps.shape[1] + j) * HEADINGS + h
        count += 1
    return count
