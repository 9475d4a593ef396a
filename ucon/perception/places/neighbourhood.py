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
"""Weight of the prior that rooms are as usual, in units of a thing at distance 0."""


@lru_cache(maxsize=1)
def _rooms() -> tuple[dict[str, int], NDArray[np.float64]]:
    """Number of each of the R kinds of rooms, and how usual each is (R,): the mean over all furniture."""
    book = catalogue()
    names = sorted({room for name in book.names for room in book[name].rooms if room != "all"})
    number = {room: k for k, room in enumerate(names)}
    furniture = [name for name in book.names if affordance(name).furniture]
    usual = np.mean([_rooms_of(book[name].rooms, number) for name in furniture], axis=0) + 1e-3
    return number, usual / usual.sum()


def room_numbers() -> dict[str, int]:
    """Number of each of the R kinds of rooms, as :func:`rooms_of` orders them."""
    return dict(_rooms()[0])


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


@lru_cache(maxsize=256)
def _rooms_of_all(categories: tuple[str, ...]) -> NDArray[np.float64]:
    """p(kind of room) of n categories, (n, R)."""
    return np.array([rooms_of(name) for name in categories])


@lru_cache(maxsize=1)
def _telling() -> tuple[dict[str, int], NDArray[np.float64]]:
    """Furniture whose rooms the catalogue names: the row of each, and p(kind of room) (F, R)."""
    book, (number, _) = catalogue(), _rooms()
    names = [name for name in book.names if affordance(name).furniture and any(r in number for r in book[name].rooms)]
    return {name: row for row, name in enumerate(names)}, _rooms_of_all(tuple(names))


def interest(known: SemanticMap, names: tuple[str, ...], wanted: NDArray[np.float64]) -> NDArray[np.float32]:
    """Factors of the worth of unexplored cells, given which anchors are still to be found.

    Each piece of furniture seen is evidence for or against its surroundings: the logarithm of how much likelier than
    usual the wanted anchors are in its kinds of rooms. The mean factor over unexplored cells next to explored ones is
    1.

    Args:
        known: the map.
        names: the A anchor categories.
        wanted: (A,) the probability mass of each that waits in unexplored space.

    Returns:
        (257, 257) float32; all 1 where nothing is wanted.
    """
    total = sum(wanted.tolist())
    if total <= 0.0:
        return np.ones((SIZE, SIZE), np.float32)
    _, usual = _rooms()
    ratio = wanted @ _rooms_of_all(names) / total / usual
    tracks, evidence = _evidence(known, ratio)
    window, around = _spread(known.cells_of(tracks), evidence, known.extent(0))
    out = np.exp(around[..., 0] / (around[..., 1] + _DOUBT / (2.0 * np.pi * _SPREAD_CELLS**2)))
    explored = known.explored[window]
    border = (cv2.dilate(explored, np.ones((5, 5), np.uint8)) > 0) & (explored == 0)
    usual_worth = out[border].mean() if border.any() else 1.0
    factors = np.full((SIZE, SIZE), np.round(1.0 / usual_worth, 3), np.float32)
    factors[window] = np.round(out / usual_worth, 3)
    return factors


def _evidence(known: SemanticMap, ratio: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Tracks of the n pieces of furniture seen, and the evidence (n,) of each.

    That is the logarithm of how much likelier than usual the wanted anchors are in the rooms of its category. ``ratio``
    (R,): p(room) of the wanted anchors over the usual one.
    """
    row, rooms = _telling()
    said = np.clip(np.log(np.maximum(rooms @ ratio, 1e-6)), -_MOST, _MOST).astype(np.float32)
    seen = [(track, row[name]) for name, tracks in known.instances.items() if name in row for track in tracks]
    tracks, rows = np.array(seen, np.int64).reshape(-1, 2).T
    shown = known.box[tracks, 3] >= known.box[tracks, 0]
    return tracks[shown], said[rows[shown]]


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
