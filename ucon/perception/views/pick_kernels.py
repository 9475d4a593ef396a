"""Selects a few views out of thousands: the best, no two with the same heading from nearly the same node."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import F64, I32, jit

I64: TypeAlias = NDArray[np.int64]

#: Views with one heading count as alike if their nodes are at most this many cells apart.
ALIKE_CELLS = 3


@jit
def pick(nodes: I32, headings: int, score: F64, order: I64, most: int, picked: I64, count: int) -> int:
    """Append views to a selection, in the given order, skipping those that are alike to a selected one.

    Args:
        nodes: (n, 2) int32.
        headings: their number H.
        score: (n * H,) float64, of each node and heading; the first score of 0 or less ends the selection.
        order: (n * H,) int64, views as node * H + heading.
        most: size of the selection.
        picked: (>= most,) int64, the selection; has ``count`` entries, more are written.
        count: entries before.

    Returns:
        Entries after.
    """
    for k in range(order.shape[0]):
        if count >= most:
            break
        view = order[k]
        if score[view] <= 0.0:
            break
        i, j, heading = nodes[view // headings, 0], nodes[view // headings, 1], view % headings
        alike = False
        for m in range(count):
            other = picked[m]
            if other % headings == heading:
                di, dj = nodes[other // headings, 0] - i, nodes[other // headings, 1] - j
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
    """Select up to ``most`` views: ``first``, then three quarters by score, the rest by gain.

    Args:
        nodes: (n, 2) int32 cells.
        score: (n, H) float64, of the best pitch of each heading.
        gain: (n, H) float64, at that pitch.
        most: size of the selection.
        first: a view that is always selected, as node * H + heading; -1 for none.

    Returns:
        (m,) int64, views as node * H + heading.
    """
    picked = np.full(most, -1, np.int64)
    count = 0
    if first >= 0:
        picked[0], count = first, 1
    flat = np.ascontiguousarray(score.reshape(-1))
    by_score = np.argsort(-flat, kind="stable")
    count = pick(nodes, score.shape[1], flat, by_score, (3 * most) // 4, picked, count)
    by_gain = np.argsort(-gain.reshape(-1), kind="stable")
    count = pick(nodes, score.shape[1], flat, by_gain, most, picked, count)
    return picked[:count]
