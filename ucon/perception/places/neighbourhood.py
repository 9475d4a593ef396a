"""Where an anchor that was not seen yet is likely to be: near furniture of the rooms it belongs to.

Knowledge of rooms is the catalogue's: in which kinds of rooms a category is usually found, the most usual first.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.semantic_map import SIZE, SemanticMap
from ucon.perception.places.affordances import affordance
from ucon.perception.views.view_kernels import CELL_M

#: A thing's evidence spreads as a Gaussian of this standard deviation.
_SPREAD_CELLS = 1.5 / CELL_M
_REACH_CELLS = 26
"""The Gaussian is cut off here: more than four standard deviations."""
_MOST = 1.5
"""Largest evidence of one thing for or against, a natural logarithm."""
_DOUBT = 0.6
"""Weight of the prior "as usual", in things at distance 0."""


@lru_cache(maxsize=1)
def _rooms() -> tuple[dict[str, int], NDArray[np.float64]]:
    """Number of each of the R kinds of rooms, and how usual each is (R,): the mean over all furniture."""
    book = catalogue()
    names = sorted({room for name in book.names for room in book[name].rooms if room != "all"})
    number = {room: k for k, room in enumerate(names)}
    furniture = [name for name in book.names if affordance(name).furniture]
    usual = np.mean([_rooms_of(book[name].rooms, number) for name in furniture], axis=0) + 1e-3
    return number, usual / usual.sum()


def _rooms_of(rooms: tuple[str, ...], number: dict[str, int]) -> NDArray[np.float64]:
    """p(kind of room) (R,) from a catalogue entry's rooms, the most usual first: weights 1, 1/2, 1/3, ..."""
    p = np.zeros(len(number))
    for rank, room in enumerate(room for room in rooms if room in number):
        p[number[room]] += 1.0 / (rank + 1)
    return p / p.sum() if p.any() else np.full(len(number), 1.0 / len(number))


@lru_cache(maxsize=4096)
def rooms_of(category: str) -> NDArray[np.float64]:
    """Probability of each kind of room for a category.

    Returns:
        (R,) float64 that sums to 1; uniform for a name outside the catalogue.
    """
    number, _ = _rooms()
    return _rooms_of(catalogue()[category].rooms if category in catalogue() else (), number)


def _has_rooms(category: str) -> bool:
    """Whether the catalogue names rooms for a category."""
    return any(room in _rooms()[0] for room in catalogue()[category].rooms)


def interest(known: SemanticMap, wanted: dict[str, float]) -> NDArray[np.float32]:
    """Factors of the worth of unexplored cells, given which anchors are still to be found.

    Each piece of furniture seen is evidence for or against its surroundings: the logarithm of how much likelier than
    usual the wanted anchors are in its kinds of rooms. The mean factor over unexplored cells next to explored ones is
    1.

    Args:
        known: the map.
        wanted: by anchor category, the probability mass that waits in unexplored space.

    Returns:
        (257, 257) float32; all 1 where ``wanted`` is empty.
    """
    _, usual = _rooms()
    total = sum(wanted.values())
    if total <= 0.0:
        return np.ones((SIZE, SIZE), np.float32)
    ratio = np.fromiter(wanted.values(), float, len(wanted)) @ _rooms_of_all(tuple(wanted)) / total / usual
    by_name = {
        name: _evidence(name, ratio) for name in known.instances if affordance(name).furniture and _has_rooms(name)
    }
    tracks = np.array([k for name in by_name for k in known.instances[name] if known.seen(k)], np.int64)
    evidence = np.array([by_name[known.category[k]] for k in tracks], np.float32)
    window, around = _spread(known.cells_of(tracks), evidence, known.extent(0))
    out = np.exp(around[..., 0] / (around[..., 1] + _DOUBT / (2.0 * np.pi * _SPREAD_CELLS**2)))
    explored = known.explored[window]
    border = (cv2.dilate(explored, np.ones((5, 5), np.uint8)) > 0) & (explored == 0)
    usual_worth = out[border].mean() if border.any() else 1.0
    factors = np.full((SIZE, SIZE), 1.0 / usual_worth)
    factors[window] = out / usual_worth
    return np.round(factors, 3, out=factors).astype(np.float32)


@lru_cache(maxsize=256)
def _rooms_of_all(categories: tuple[str, ...]) -> NDArray[np.float64]:
    """p(kind of room) of n categories, (n, R)."""
    return np.array([rooms_of(name) for name in categories])


def _evidence(category: str, ratio: NDArray[np.float64]) -> float:
    """Logarithm of how much likelier than usual the wanted anchors are in a category's rooms.

    ``ratio`` (R,): p(room) of the wanted anchors over the usual one.
    """
    return float(np.clip(np.log(max(float(rooms_of(category) @ ratio), 1e-6)), -_MOST, _MOST))


def _spread(
    cells: NDArray[np.int64], evidence: NDArray[np.float32], extent: tuple[int, int, int, int]
) -> tuple[tuple[slice, slice], NDArray[np.float32]]:
    """Spread the evidence (n,) of things in cells (n, 2) over their surroundings.

    Returns a window of the map that holds all of them and the ``extent``, and there (rows, columns, 2): the summed
    evidence and the summed weight.
    """
    i0, i1, j0, j1 = extent
    low = np.minimum(cells.min(0, initial=SIZE), (i0, j0)) - _REACH_CELLS
    high = np.maximum(cells.max(0, initial=0) + 1, (i1, j1)) + _REACH_CELLS
    low, high = np.maximum(low, 0), np.minimum(high, SIZE)
    summed = np.zeros((*(high - low), 2), np.float32)
    np.add.at(summed, tuple((cells - low).T), np.stack([evidence, np.ones_like(evidence)], -1))
    window = (slice(int(low[0]), int(high[0])), slice(int(low[1]), int(high[1])))
    return window, np.asarray(cv2.GaussianBlur(summed, (0, 0), _SPREAD_CELLS), np.float32)
