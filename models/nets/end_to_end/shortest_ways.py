"""Shortest paths over a remembered floor: the number of actions to every pose, and the first action.

Moves and turns cost one action each, as in the task. Geometry alone decides and no gradient passes; what is learned is
where to go (:mod:`models.nets.end_to_end.places_to_go`).
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from ucon.core.jit import I32, U8, jit
from ucon.task.actions import Action

I64 = NDArray[np.int64]

FAR = 255
"""Distance of poses that cannot be reached, or not within 254 actions."""
STAY = 3
"""First action of the pose that the agent is in; others are the numbers of MoveAhead, RotateRight and RotateLeft."""

assert (Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.ROTATE_LEFT) == (0, 1, 2)


@jit
def _search(ok: U8, width: int, start: int, steps: U8, first: U8, queue: I32) -> None:
    """Breadth-first search over states 4 * cell + heading.

    Args:
        ok: (W * W,) 1 for cells that may be stood on; the border has to be 0.
        width: W.
        start: state of the agent.
        steps: (4 * W * W,) is filled with distances.
        first: (4 * W * W,) is filled with first actions.
        queue: (4 * W * W,) scratch memory.
    """
    steps[:] = 255
    steps[start], first[start] = 0, 3
    queue[0], head, tail = start, 0, 1
    while head < tail:
        state = queue[head]
        head += 1
        d = steps[state]
        if d == 254:
            break
        h = state & 3
        ahead = 4 * width if h == 0 else (4 if h == 1 else (-4 * width if h == 2 else -4))
        for action in range(3):
            new = state + ahead if action == 0 else (state & ~3) | ((h + (3 if action == 1 else 1)) & 3)
            if steps[new] == 255 and (action != 0 or ok[new >> 2] != 0):
                steps[new] = d + 1
                first[new] = action if d == 0 else first[state]
                queue[tail] = new
                tail += 1


@jit
def _search_all(free: U8, heading: I64, steps: U8, first: U8) -> None:
    """Search for each of N agents.

    ``steps`` and ``first`` (N, 4, C, C) get the nearest of each block of 2 x 2 cells.
    """
    width, coarse = free.shape[1] + 2, steps.shape[2]
    queue = np.empty(4 * width * width, np.int32)
    fine, label = np.empty(4 * width * width, np.uint8), np.empty(4 * width * width, np.uint8)
    ok = np.zeros((width, width), np.uint8)
    middle = (width // 2) * width + width // 2
    for n in range(free.shape[0]):
        ok[1:-1, 1:-1] = free[n]
        _search(ok.reshape(-1), width, 4 * middle + heading[n] % 4, fine, label, queue)
        for a in range(coarse):
            for b in range(coarse):
                corner = 4 * ((2 * a + 1) * width + 2 * b + 1)
                for h in range(4):
                    best = corner + h
                    for other in (corner + h + 4, corner + h + 4 * width, corner + h + 4 * width + 4):
                        best = other if fine[other] < fine[best] else best
                    steps[n, h, a, b], first[n, h, a, b] = fine[best], label[best]


def shortest_ways(free: Tensor, heading: Tensor) -> tuple[Tensor, Tensor]:
    """Distances and first actions from the middle of each floor.

    Computed on the CPU, whatever the device of the inputs.

    Args:
        free: (N, W, W) bool, cells that may be stood on; W is odd, and the middle cell may always be stood on.
        heading: (N,) int, quarter turns; 0 looks along the first axis, 1 along the second.

    Returns:
        steps (N, 4, C, C) uint8, actions to the nearest cell of each block of 2 x 2, by heading there, or :data:`FAR`;
        first (N, 4, C, C) uint8, the first action of that path, :data:`STAY` where the agent is. C = (W + 1) / 2.
    """
    grid = free.detach().to("cpu", torch.uint8).contiguous().numpy()
    n, width = grid.shape[:2]
    coarse = (width + 1) // 2
    steps = np.empty((n, 4, coarse, coarse), np.uint8)
    first = np.empty((n, 4, coarse, coarse), np.uint8)
    _search_all(grid, heading.detach().to("cpu", torch.int64).numpy(), steps, first)
    return torch.from_numpy(steps).to(free.device), torch.from_numpy(first).to(free.device)
