"""Shortest action sequences: breadth-first search over (cell, heading), every action one step.

The planner may use the true free grid (``nav`` of the environment) or what the map has seen. Goals always come from the
map. A move that failed marks its cell in the map, and the next plan avoids it. A robot that moves continuously plans on
the lattice of its moves (:mod:`ucon.perception.mapping.lattice`), around the obstacles that it saw.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import jit
from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.body import PAPER_BODY, Body
from ucon.perception.mapping.lattice import Lattice
from ucon.perception.mapping.map_kernels import RADIUS_M
from ucon.perception.mapping.nav import Nav
from ucon.perception.mapping.semantic_map import HALF, SIZE, SemanticMap, View
from ucon.task.actions import Action

I32: TypeAlias = NDArray[np.int32]

UNREACHED = 1 << 29
#: A robot that reaches fewer poses than this, those of three nodes, is stuck.
_FEW = 18
_TURN = {0: (), 1: (Action.ROTATE_LEFT,), 2: (Action.ROTATE_LEFT, Action.ROTATE_LEFT), 3: (Action.ROTATE_RIGHT,)}
_PRIMITIVES = (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT)


@jit
def _search(
    free: NDArray[np.bool_], i: int, j: int, heading: int, steps: I32, moves: I32, came: NDArray[np.int8], queue: I32
) -> int:
    """Breadth-first search from one pose.

    Writes at (i, j, heading) int32 ``steps`` and ``moves`` and int8 ``came``, the last action of the path: 0 move, 1
    left, 2 right, -1 none. Returns the number of states in ``queue``.
    """
    n = free.shape[0]
    di, dj = (1, 0, -1, 0), (0, 1, 0, -1)
    steps[i, j, heading], moves[i, j, heading], came[i, j, heading] = 0, 0, -1
    queue[0] = (i * n + j) * 4 + heading
    head, tail = 0, 1
    while head < tail:
        state = queue[head]
        head += 1
        h, j0 = state & 3, (state >> 2) % n
        i0 = (state >> 2) // n
        for action in range(3):
            if action == 0:
                i1, j1, h1 = i0 + di[h], j0 + dj[h], h
                if i1 < 0 or j1 < 0 or i1 >= n or j1 >= n or not free[i1, j1]:
                    continue
            else:
                i1, j1, h1 = i0, j0, (h + (1 if action == 1 else 3)) & 3
            if steps[i1, j1, h1] < UNREACHED:
                continue
            steps[i1, j1, h1] = steps[i0, j0, h] + 1
            moves[i1, j1, h1] = moves[i0, j0, h] + (action == 0)
            came[i1, j1, h1] = action
            queue[tail] = (i1 * n + j1) * 4 + h1
            tail += 1
    return tail


class Planner(PartlyShared):
    """Path lengths and plans from the agent's pose, for one episode.

    Attributes:
        steps: (257, 257, H) int32, actions to stand at a cell with a heading; UNREACHED where there is no path.
        moves: (257, 257, H) int32, those of the actions that are MoveAhead.
        origin: the pose that the paths start from.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_true", "_used"})

    def __init__(self, nav: Nav | Mapping[str, Any] | None = None, body: Body = PAPER_BODY) -> None:
        """Choose the grid.

        Args:
            nav: the environment's true grid (``free``, ``start``), or None to use what the map has seen.
            body: the agent's; that of the paper's rules by default.
        """
        self._true = None if nav is None else _in_window(nav["free"], nav["start"])
        self.steps = np.full((SIZE, SIZE, body.headings), UNREACHED, np.int32)
        self.moves = np.zeros((SIZE, SIZE, body.headings), np.int32)
        self._came = np.zeros((SIZE, SIZE, body.headings), np.int8)
        self._lattice = None if body.exact else Lattice(UNREACHED)
        self._used: NDArray[np.int32] = np.zeros(0, np.int32)
        self.origin = View(HALF, HALF, 0)

    def free(self, known: SemanticMap) -> NDArray[np.bool_]:
        """Nodes that a plan may pass.

        Returns:
            (257, 257) bool, indexed as the map.
        """
        if self._true is not None:
            return self._true & (known.bumped == 0)
        i0, i1, j0, j1 = known.extent(margin=6)
        free = np.zeros((SIZE, SIZE), bool)
        free[i0:i1, j0:j1] = known.passable()[i0:i1, j0:j1]
        return free

    def update(self, known: SemanticMap) -> None:
        """Compute all paths from the map's current pose. Call it before :meth:`cost` and :meth:`plan`."""
        self.origin = view = known.view
        self.steps.reshape(-1)[self._used] = UNREACHED
        if self._lattice is not None:
            self._used = self._on_lattice(self._lattice, known)
            return
        free = self.free(known)
        free[view.i, view.j] = True
        queue = np.empty(SIZE * SIZE * 4, np.int32)
        count = _search(free, view.i, view.j, view.heading, self.steps, self.moves, self._came, queue)
        self._used = queue[:count].copy()

    def _on_lattice(self, lattice: Lattice, known: SemanticMap) -> NDArray[np.int32]:
        """Compute all paths of a robot that moves continuously; returns the rows of ``steps`` that were written.

        Where it is stuck because drift or noise put obstacles where it stands, paths for a smaller radius are computed.
        """
        assert known.obstacles is not None
        view, window, used = known.view, known.extent(margin=6), np.zeros(0, np.int32)
        for radius_m in (RADIUS_M, 0.5 * RADIUS_M, 0.0):
            self.steps.reshape(-1)[used] = UNREACHED
            free = known.obstacles.free(radius_m)
            used = lattice.search(free, window, view.xy, view.heading, (self.steps, self.moves))
            if len(used) >= _FEW:
                break
        return used

    def cost(self, goal: View) -> int:
        """Number of actions to reach a pose, LookUp and LookDown included.

        Returns:
            UNREACHED or more where there is no path.
        """
        return int(self.steps[goal.i, goal.j, goal.heading]) + abs(goal.pitch_deg - self.origin.pitch_deg) // 30

    def plan(self, goal: View) -> list[Action]:
        """Actions from ``origin`` to a pose; LookUp and LookDown come last.

        Returns:
            An empty list where there is no path, or where the agent is there already.
        """
        if self.steps[goal.i, goal.j, goal.heading] >= UNREACHED:
            return []
        delta = (goal.pitch_deg - self.origin.pitch_deg) // 30
        looks = [Action.LOOK_UP if delta > 0 else Action.LOOK_DOWN] * abs(delta)
        if self._lattice is not None:
            there = self._lattice.backwards(goal.i, goal.j, goal.heading)[::-1]
            return [_PRIMITIVES[action] for action in there] + looks
        i, j, h = goal.i, goal.j, goal.heading
        backwards: list[Action] = []
        while (action := int(self._came[i, j, h])) >= 0:
            backwards.append(_PRIMITIVES[action])
            if action == 0:
                i, j = i - (1, 0, -1, 0)[h], j - (0, 1, 0, -1)[h]
            else:
                h = (h - (1 if action == 1 else 3)) % 4
        return backwards[::-1] + looks


def turns(heading: int, wanted: int) -> tuple[Action, ...]:
    """Rotations from one heading to another, at most two.

    Args:
        heading: quarter turns counter-clockwise.
        wanted: quarter turns counter-clockwise.
    """
    return _TURN[(wanted - heading) % 4]


def _in_window(free: NDArray[np.bool_], start: tuple[int, int]) -> NDArray[np.bool_]:
    """Put the environment's grid into the map's window, with its start cell at the centre; (257, 257) bool."""
    out = np.zeros((SIZE, SIZE), bool)
    nx, ny = free.shape
    i0, j0 = HALF - int(start[0]), HALF - int(start[1])
    a0, b0, a1, b1 = max(i0, 0), max(j0, 0), min(i0 + nx, SIZE), min(j0 + ny, SIZE)
    out[a0:a1, b0:b1] = free[a0 - i0 : a1 - i0, b0 - j0 : b1 - j0]
    return out
