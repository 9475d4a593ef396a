"""Picks a few views out of thousands: the best, none of which looks the same way from nearly the same spot."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import F64, I32, jit

I64: TypeAlias = NDArray[np.int64]

#: Views with one heading are alike within this many cells.
ALIKE_CELLS = 3


@jit
def pick(nodes: I32, score: F64, order: I64, most: int, picked: I64, count: int) -> int:
    """Append to ``picked`` (node * 4 + heading) views in the given order until there are ``most``; returns how many.

    nodes (n, 2); score (n * 4) of the best pitch, views without any are left out; ``count`` are picked already.
    """
    for k in range(order.shape[0]):
        if count >= most:
            break
        view = order[k]
        if score[view] <= 0.0:
            break
        i, j, heading = nodes[view >> 2, 0], nodes[view >> 2, 1], view & 3
        alike = False
        for m in range(count):
            other = picked[m]
            if (other & 3) == heading:
                di, dj = nodes[other >> 2, 0] - i, nodes[other >> 2, 1] - j
                if max(abs(di), abs(dj)) <= ALIKE_CELLS:
                    alike = True
                    break
        if not alike:
            picked[count] = view
            count += 1
    return count


def picked_views(
    nodes: NDArray[np.int32], score: NDArray[np.float64], gain: NDArray[np.float64], most: int, first: int = -1
) -> NDArray[np.int64]:
    """Up to ``most`` views as node * 4 + heading: ``first`` (-1: none), three quarters by score, the rest by gain.

    Args:
        nodes: (n, 2) cells.
        score: (n, 4) of the best pitch of each heading.
        gain: (n, 4) of that pitch.
        most: how many.
        first: a view that is picked whatever its score.
    """
    picked = np.full(most, -1, np.int64)
    count = 0
    if first >= 0:
        picked[0], count = first, 1
    flat = np.ascontiguousarray(score.reshape(-1))
    by_score = np.argsort(-flat, kind="stable")
    count = pick(nodes, flat, by_score, (3 * most) // 4, picked, count)
    by_gain = np.argsort(-gain.reshape(-1), kind="stable")
    count = pick(nodes, flat, by_gain, most, picked, count)
    return picked[:count]
