"""What stands together: near which of the things seen is an anchor that was not seen yet likelier to be.

Knowledge of rooms is the catalogue's: in which kinds of rooms a category is usually found, the most usual first.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.perception.places import affordance
from ucon.perception.semantic_map import SIZE, SemanticMap
from ucon.perception.view_kernels import CELL_M

#: Standard deviation of the neighbourhood of a thing.
_SPREAD_CELLS = 1.5 / CELL_M
_MOST = 1.5
"""Natural logarithm of the most that one neighbour speaks for or against."""
_DOUBT = 0.6
"""Weight of knowing nothing, in neighbours at no distance."""


@lru_cache(maxsize=1)
def _rooms() -> tuple[dict[str, int], NDArray[np.float64]]:
    """Number of every kind of room, and how usual it is (R,): the mean over furniture."""
    book = catalogue()
    names = sorted({room for name in book.names for room in book[name].rooms if room != "all"})
    number = {room: k for k, room in enumerate(names)}
    furniture = [name for name in book.names if affordance(name).furniture]
    usual = np.mean([_rooms_of(book[name].rooms, number) for name in furniture], axis=0) + 1e-3
    return number, usual / usual.sum()


def _rooms_of(rooms: tuple[str, ...], number: dict[str, int]) -> NDArray[np.float64]:
    p = np.zeros(len(number))
    for rank, room in enumerate(room for room in rooms if room in number):
        p[number[room]] += 1.0 / (rank + 1)
    return p / p.sum() if p.any() else np.full(len(number), 1.0 / len(number))


@lru_cache(maxsize=4096)
def rooms_of(category: str) -> NDArray[np.float64]:
    """p(kind of room) of a category, (R,); even for a name outside the catalogue."""
    number, _ = _rooms()
    return _rooms_of(catalogue()[category].rooms if category in catalogue() else (), number)


def _has_rooms(category: str) -> bool:
    return any(room in _rooms()[0] for room in catalogue()[category].rooms)


def interest(known: SemanticMap, wanted: dict[str, float]) -> NDArray[np.float32]:
    """(257, 257) factors of the worth of unexplored cells, given the mass of anchors that wait there.

    Every piece of furniture seen speaks for or against its neighbourhood by how much likelier than usual the
    wanted anchors are in its kind of rooms. The mean over the border of the unexplored is 1.
    """
    _, usual = _rooms()
    total = sum(wanted.values())
    if total <= 0.0:
        return np.ones((SIZE, SIZE), np.float32)
    wish = sum((mass * rooms_of(name) for name, mass in wanted.items()), np.zeros(len(usual))) / total / usual
    says, heard = np.zeros((SIZE, SIZE), np.float32), np.zeros((SIZE, SIZE), np.float32)
    for name, tracks in known.instances.items():
        if not affordance(name).furniture or not _has_rooms(name):
            continue
        word = np.float32(np.clip(np.log(max(float(rooms_of(name) @ wish), 1e-6)), -_MOST, _MOST))
        for track in tracks:
            if known.seen(track):
                i, j = known.cell_of(track)
                says[i, j] += word
                heard[i, j] += 1.0
    peak = 1.0 / (2.0 * np.pi * _SPREAD_CELLS**2)
    around = cv2.GaussianBlur(np.stack([says, heard], -1), (0, 0), _SPREAD_CELLS)
    out = np.exp(around[..., 0] / (around[..., 1] + _DOUBT * peak))
    border = (cv2.dilate(known.explored, np.ones((5, 5), np.uint8)) > 0) & (known.explored == 0)
    if border.any():
        out /= out[border].mean()
    return np.round(out, 3).astype(np.float32)
