"""Which category a simulated detector confuses with which: similar size and shape, found in the same rooms.

Computed from the catalogue, not measured on a detector; real detectors confuse things by looks and wording.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.perception.detectors.base import vocabulary


@lru_cache(maxsize=1)
def _features() -> tuple[dict[str, int], NDArray[np.float64], NDArray[np.str_], NDArray[np.str_], NDArray[np.float64]]:
    """Catalogue features of the n names of the vocabulary.

    Returns:
        Row of each name; sorted log sizes (n, 3); shapes (n,); semantic groups (n,); rooms (n, r), rows of length 1.
    """
    names, book = vocabulary(), catalogue()
    rows = [book[name] for name in names]
    types = sorted({room for row in rows for room in row.rooms})
    rooms = np.array([[float(room in row.rooms) for room in types] for row in rows])
    rooms /= np.maximum(np.linalg.norm(rooms, axis=1, keepdims=True), 1e-9)
    size = np.log(np.array([sorted(row.size) for row in rows]))
    shape, group = np.array([row.archetype for row in rows]), np.array([row.semantic_group for row in rows])
    return {name: k for k, name in enumerate(names)}, size, shape, group, rooms


#: What makes two names alike: columns of :func:`similarity`.
FEATURES = ("size", "shape", "group", "rooms")


@lru_cache(maxsize=1)
def similarity() -> NDArray[np.float64]:
    """How alike every two names of the vocabulary are: (V, V, 4) float64, one column for each of :data:`FEATURES`.

    Minus half the mean squared log ratio of the sizes (a factor 1.5 is one standard deviation); same shape; same
    semantic group; cosine of the rooms.
    """
    _, size, shape, group, rooms = _features()
    ratio = np.square(size[:, None] - size[None]).mean(2) / np.log(1.5) ** 2
    same = shape[:, None] == shape[None], group[:, None] == group[None]
    return np.stack([-0.5 * ratio, *(np.asarray(rows, np.float64) for rows in same), rooms @ rooms.T], 2)


@lru_cache(maxsize=4096)
def confusion(name: str) -> NDArray[np.float64]:
    """Probability of every name of the vocabulary, given that a thing of category ``name`` gets a wrong one.

    Sizes count by a Gaussian over their mean squared log ratio (a factor 1.5 is one standard deviation). The same
    archetype counts six times, the same semantic group three times, shared rooms up to three times.

    Returns:
        (n,) float64 that sums to 1; 0 for ``name`` itself. Uniform where ``name`` is not in the vocabulary.
    """
    row, size, shape, group, rooms = _features()
    if name not in row:
        return np.full(len(row), 1.0 / len(row))
    k = row[name]
    ratio = np.square(size - size[k]).mean(1) / np.log(1.5) ** 2
    weight = np.exp(-0.5 * ratio) + 1e-9
    weight *= (
        np.where(shape == shape[k], 6.0, 1.0) * np.where(group == group[k], 3.0, 1.0) * (1.0 + 2 * rooms @ rooms[k])
    )
    weight[k] = 0.0
    result: NDArray[np.float64] = weight / weight.sum()
    return result


def wrong_name(name: str, draw: float) -> str:
    """The wrong name that a uniform random number stands for.

    Args:
        name: the true category.
        draw: a number from [0, 1).
    """
    names = vocabulary()
    k = int(np.searchsorted(np.cumsum(confusion(name)), draw, side="right"))
    return names[min(k, len(names) - 1)]
