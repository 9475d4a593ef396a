"""The cheapest pose for a thing, on a map of a few cells."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.perception.mapping.map_kernels import CELL_M
from ucon.perception.mapping.planner import UNREACHED
from ucon.perception.views.approach_kernels import UNSEEN_COST, best_views

HALF, SIDE, EYE_M = 4, 9, 1.25


def best(steps: np.ndarray, thing: np.ndarray, reach_m: float) -> tuple[int, list[int]]:
    """Cost and pose (i, j, heading, row of eyes) for one thing, with an empty map and a level camera."""
    height, walls = np.zeros((SIDE, SIDE), np.float32), np.zeros((2, SIDE, SIDE), np.uint8)
    out, cost = np.full((1, 4), -1, np.int32), np.full(1, UNREACHED, np.int32)
    eyes, seen = np.array([[EYE_M, 1.0, 0.0, 0.0]]), np.array([[1e6, 1.0]])
    best_views(
        thing[None], np.array([reach_m]), (steps, height, walls, HALF), np.ones((SIDE, SIDE), np.uint8), eyes, 0, seen,
        np.zeros((0, 5), np.int32), out, cost,
    )  # fmt: skip
    return int(cost[0]), out[0].tolist()


@pytest.mark.parametrize("heading", range(4))
def test_a_node_that_is_reached_in_one_heading_counts(heading: int) -> None:
    ahead = np.array([(1, 0, -1, 0)[heading], (0, 1, 0, -1)[heading]]) * 3 * CELL_M
    thing = np.concatenate([ahead - 0.02, [EYE_M - 0.02], ahead + 0.02, [EYE_M + 0.02]])
    steps = np.full((SIDE, SIDE, 4), UNREACHED, np.int32)
    steps[HALF, HALF, heading] = 7
    cost, pose = best(steps, thing, 4 * CELL_M)
    assert pose == [HALF, HALF, heading, 0]
    assert cost in (7, 7 + UNSEEN_COST)
    assert best(steps, thing, 2.5 * CELL_M) == (UNREACHED, [-1] * 4), "out of reach"
    steps[HALF, HALF] = np.roll(steps[HALF, HALF], 2)
    assert best(steps, thing, 4 * CELL_M) == (UNREACHED, [-1] * 4), "with its back to it"
