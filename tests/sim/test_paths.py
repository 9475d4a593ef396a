from collections import deque
from itertools import pairwise

import numpy as np
import pytest

from ucon.core.errors import EpisodeError
from ucon.core.rng import stream
from ucon.sim import paths


def slow_distances(free, sources, costs):
    """Reference: Bellman's relaxation until nothing changes, without a queue."""
    dist = np.full(free.shape, 10**6)
    for (i, j), cost in zip(sources, costs, strict=True):
        if free[i, j]:
            dist[i, j] = min(dist[i, j], cost)
    while True:
        padded = np.pad(dist, 1, constant_values=10**6)
        near = np.minimum.reduce([padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
        better = np.where(free, np.minimum(dist, near + 1), 10**6)
        if (better == dist).all():
            return np.where(dist >= 10**6, -1, dist)
        dist = better


@pytest.mark.parametrize("seed", range(20))
def test_distances_agree_with_relaxation_also_with_costs(seed):
    rng = stream(seed, "paths")
    free = rng.random((17, 23)) > 0.3
    sources = rng.integers(0, (17, 23), (6, 2))
    costs = rng.integers(0, 30, 6) if seed % 2 else np.zeros(6, int)
    assert (paths.distances(free, sources, costs) == slow_distances(free, sources, costs)).all()


def test_sources_outside_or_on_walls_are_ignored():
    free = np.ones((3, 3), bool)
    free[1, 1] = False
    assert (paths.distances(free, [(1, 1), (-1, 0), (3, 0)]) == -1).all()


def test_path_walks_down_to_a_source():
    free = np.ones((6, 5), bool)
    free[2, :4] = False
    dist = paths.distances(free, [(0, 0)])
    cells = paths.path(dist, (5, 0))
    assert cells[0] == (5, 0)
    assert cells[-1] == (0, 0)
    assert len(cells) - 1 == dist[5, 0] == 13
    assert all(abs(a - c) + abs(b - d) == 1 for (a, b), (c, d) in pairwise(cells))
    assert paths.metres(dist[5, 0]) == 3.25


def test_path_from_nowhere_is_an_error():
    with pytest.raises(EpisodeError, match="no path"):
        paths.path(np.full((2, 2), -1, np.int32), (0, 0))


def test_components_count_pieces():
    free = np.ones((5, 5), bool)
    free[2] = False
    labels = paths.components(free)
    assert labels.max() == 1
    assert (labels[2] == -1).all()
    queue, seen = deque([(0, 0)]), {(0, 0)}
    while queue:
        i, j = queue.popleft()
        for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if 0 <= a < 5 and 0 <= b < 5 and free[a, b] and (a, b) not in seen:
                seen.add((a, b))
                queue.append((a, b))
    assert {(int(i), int(j)) for i, j in np.argwhere(labels == labels[0, 0])} == seen
