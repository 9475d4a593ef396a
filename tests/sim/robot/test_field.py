"""Shortest paths of a disc, and the lattice that exact moves and turns reach."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.sim.homes import hand_house
from ucon.scenes.spec import WALL_THICKNESS_M
from ucon.sim.arrangement import Arrangement
from ucon.sim.robot.field import CELL_M, PathGrid
from ucon.sim.robot.floor import Floor
from ucon.sim.robot.lattice import MOVE_COST, NEVER, Lattice

START = (6.125, 1.125)


@pytest.fixture(scope="module")
def floor() -> Floor:
    return Floor(hand_house(), Arrangement(), 0.18, 0.05, 1.0)


def test_in_the_open_a_path_is_hardly_longer_than_the_line(floor: Floor) -> None:
    grid, rng = PathGrid(floor), np.random.default_rng(1)
    seen = 0
    for _ in range(300):
        a, b = rng.uniform((0.5, 0.5), (9.5, 3.5), (2, 2))
        way = float(np.hypot(*(b - a)))
        if floor.clearance(*a) < 0.2 or way < 0.5 or floor.free_way(*a, *(b - a)) < way:
            continue
        seen += 1
        assert way - 1e-9 <= grid.field(*a).at(*b) <= 1.028 * way + 2 * CELL_M
    assert seen > 50


def test_round_a_wall_it_goes_through_the_doorway(floor: Floor) -> None:
    """The path is a taut string around both jambs, 0.18 m away from them."""
    field = PathGrid(floor).field(4.5, 3.5)
    beside, above, r = 0.5 - WALL_THICKNESS_M / 2, 1.0, floor.radius_m
    away = math.hypot(beside, above)
    arc = 1.5 * math.pi - math.atan2(above, -beside) - math.acos(r / away)
    taut = 2 * (math.sqrt(away**2 - r**2) + r * arc) + WALL_THICKNESS_M
    assert taut - 0.05 <= field.at(5.5, 3.5) <= 1.028 * taut
    assert field.at(4.5, 10.0) == np.inf


def test_a_limit_ends_the_search(floor: Floor) -> None:
    grid = PathGrid(floor)
    near, all_of_it = grid.field(*START, 1.0).metres, grid.field(*START).metres
    within = all_of_it <= 1.0
    assert np.array_equal(near[within], all_of_it[within])
    assert np.isfinite(near).sum() < np.isfinite(all_of_it).sum()


def test_paths_of_the_lattice_touch_nothing_and_cost_what_they_say(floor: Floor) -> None:
    lattice = Lattice(floor, START, 30.0, 0.25)
    reached = np.argwhere(lattice.cost < NEVER)
    assert len(reached) > 1000
    for a, b, heading in reached[:: len(reached) // 40].tolist():
        path = lattice.path(lattice.cost, (a, b), heading)
        (x, y), k = START, 0
        for step in path:
            k = (k + step) % 6
            if step == 0:
                dx, dy = 0.25 * np.cos(np.radians(30 + 60 * k)), 0.25 * np.sin(np.radians(30 + 60 * k))
                assert floor.free_way(x, y, dx, dy) == pytest.approx(0.25)
                x, y = x + dx, y + dy
        assert k == heading
        assert (x, y) == pytest.approx(tuple(lattice.xy(np.array([a, b]))))
        assert path.count(0) * MOVE_COST + len(path) - path.count(0) == lattice.cost[a, b, heading]
