"""Kernels of the shortest ways over remembered floor: the number of actions to every pose, and the first action."""

from __future__ import annotations

import numpy as np

from models.nets.end_to_end.ego_kernels import BLOCKED
from models.nets.end_to_end.memory_kernels import VISITED
from ucon.core.jit import I32, U8, jit

#: Distance of poses that cannot be reached within 254 actions.
FAR = 255
#: First action of the pose that the agent is in; others are the numbers of MoveAhead, RotateRight and RotateLeft.
STAY = 3


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
    steps[:] = FAR
    steps[start], first[start] = 0, STAY
    queue[0], head, tail = start, 0, 1
    while head < tail:
        state = queue[head]
        head += 1
        d = steps[state]
        if d == FAR - 1:
            break
        h = state & 3
        ahead = 4 * width if h == 0 else (4 if h == 1 else (-4 * width if h == 2 else -4))
        for action in range(3):
            new = state + ahead if action == 0 else (state & ~3) | ((h + (3 if action == 1 else 1)) & 3)
            if steps[new] == FAR and (action != 0 or ok[new >> 2] != 0):
                steps[new] = d + 1
                first[new] = action if d == 0 else first[state]
                queue[tail] = new
                tail += 1


@jit
def find_ways(flags: U8, pose: I32, reach: int, steps: U8, first: U8, cell: U8) -> None:
    """Shortest ways to the poses around each agent, in blocks of 2 x 2 cells.

    Moves and turns cost one action each, as in the task. The cell that is reached soonest stands for its whole block.

    Args:
        flags: (B, S, S); a cell that is blocked can be entered only if the agent stood there before.
        pose: (B, 4).
        reach: cells to each side of the agent.
        steps: (B, 4, C, C) written: actions to each pose, ``FAR`` where there is no way; C = reach + 1.
        first: (B, 4, C, C) written: first action of that way, ``STAY`` where the agent is.
        cell: (B, C, C) written: which of the block's cells, 2 * row + column.
    """
    size, side = flags.shape[1], 2 * reach + 1
    half, width, coarse = size // 2, side + 3, reach + 1
    queue = np.empty(4 * width * width, np.int32)
    fine, label = np.empty(4 * width * width, np.uint8), np.empty(4 * width * width, np.uint8)
    ok = np.zeros((width, width), np.uint8)
    start = (reach + 1) * width + reach + 1
    for b in range(flags.shape[0]):
        i0, j0 = pose[b, 0] + half - reach, pose[b, 1] + half - reach
        for a in range(side):
            for c in range(side):
                i, j = i0 + a, j0 + c
                inside = 0 <= i < size and 0 <= j < size
                ok[a + 1, c + 1] = not inside or not flags[b, i, j] & BLOCKED or flags[b, i, j] & VISITED
        _search(ok.reshape(-1), width, 4 * start + (pose[b, 2] & 3), fine, label, queue)
        for a in range(coarse):
            for c in range(coarse):
                corner = (2 * a + 1) * width + 2 * c + 1
                best, soonest = 0, 4 * FAR
                for k in range(4):
                    at = 4 * (corner + (k >> 1) * width + (k & 1))
                    sum_ = int(fine[at]) + int(fine[at + 1]) + int(fine[at + 2]) + int(fine[at + 3])
                    if sum_ < soonest:
                        best, soonest = k, sum_
                cell[b, a, c] = best
                at = 4 * (corner + (best >> 1) * width + (best & 1))
                for h in range(4):
                    steps[b, h, a, c], first[b, h, a, c] = fine[at + h], label[at + h]
