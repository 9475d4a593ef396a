"""The worth of a view for the unexplored space that it would show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ucon.perception.mapping.map_kernels import CELL_M
from ucon.perception.mapping.semantic_map import HALF, SIZE
from ucon.perception.views import space_kernels as kernels

REACH = (22, 4.0)


def cells(explored_cells: int) -> tuple[np.ndarray, ...]:
    """Arrays of a map that is explored so many cells around its centre, with nothing tall in it."""
    explored = np.zeros((SIZE, SIZE), np.uint8)
    explored[HALF - explored_cells : HALF + explored_cells + 1, HALF - explored_cells : HALF + explored_cells + 1] = 1
    height, near = np.zeros((SIZE, SIZE), np.float32), np.zeros((SIZE, SIZE), np.float32)
    return explored, height, near, np.ones((SIZE, SIZE), np.float32), np.ones((SIZE, SIZE), np.float32)


def gains(explored_cells: int) -> np.ndarray:
    """Worth of the four headings at the centre, if a square metre of unexplored space is worth 1."""
    out = np.zeros((1, 4))
    kernels.space_gain(np.array([[HALF, HALF]], np.int32), cells(explored_cells), REACH, (1.0, 0.0), out)
    return out[0]


def test_what_lies_deeper_counts_less_by_a_factor_of_e_every_two_metres() -> None:
    assert pytest.approx(math.exp(-CELL_M / 2.0), rel=1e-15) == kernels.DEEPER
    assert kernels.DEEP_CELLS * CELL_M == 3.0


def test_nothing_explored_counts_three_metres_around() -> None:
    """The rays agree to a tenth with a quarter of the circle, summed ring by ring in the continuum."""
    worth = sum(2.0 * math.pi * k * CELL_M**2 * math.exp(-(k - 1) * CELL_M / 2.0) for k in range(1, 13)) / 4.0
    assert gains(-1) == pytest.approx(worth, rel=0.1)
    deeper = worth + 2.0 * math.pi * 13 * CELL_M**2 * math.exp(-12 * CELL_M / 2.0) / 4.0
    assert gains(-1).max() < 0.5 * (worth + deeper)


def test_left_and_right_of_the_same_are_worth_the_same() -> None:
    for around in (0, 3, 8):
        found = gains(around)
        assert found == pytest.approx(found[0], rel=1e-12)


def test_explored_space_seen_from_near_is_worth_nothing() -> None:
    assert not gains(30).any()
