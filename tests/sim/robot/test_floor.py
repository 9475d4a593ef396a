"""The floor of a robot: footprints and the motion of a disc among them, against geometry and PyBullet."""

from __future__ import annotations

import pickle
import subprocess
import sys

import numpy as np
import pytest

from tests.sim.homes import hand_house
from ucon.core.geometry import matrix_from_rpy
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.cache import load_house
from ucon.sim.house import House
from ucon.sim.robot.floor import Floor
from ucon.sim.robot.live_floor import LiveFloor
from ucon.sim.shapes import CYLINDER, item_box, object_box, object_solid, object_turn, quat_of_matrix
from ucon.task.sets import load_episodes

RADIUS_M, BOTTOM_M, TOP_M = 0.18, 0.05, 1.0


def floor_of(house: House, arrangement: Arrangement | None = None, radius_m: float = RADIUS_M) -> Floor:
    return Floor(house, arrangement or Arrangement(), radius_m, BOTTOM_M, TOP_M)


def test_a_disc_stops_where_it_touches_a_wall() -> None:
    floor = floor_of(hand_house())
    # From the empty part of the second room to the wall at y = 4, half of which (0.05 m) is on this side.
    wall_y = float(hand_house().boxes[hand_house().n_items + 3 + 1][4])
    gone = floor.free_way(7.0, 1.0, 0.0, 5.0)
    inner = next(y for y in np.arange(3.0, 4.0, 1e-4) if floor.clearance(7.0, y) <= 1e-9)
    assert inner < wall_y
    assert gone == pytest.approx(inner - RADIUS_M - 1.0, abs=2e-4)


def test_it_slides_along_a_wall_and_leaves_it() -> None:
    floor = floor_of(hand_house())
    y = 1.0 + floor.free_way(7.0, 1.0, 0.0, 5.0)
    assert floor.free_way(7.0, y, 0.0, 0.25) == pytest.approx(0.0, abs=1e-6)
    assert floor.free_way(7.0, y, 0.2, 0.0) == pytest.approx(0.2)
    assert floor.free_way(7.0, y, 0.1, -0.1) == pytest.approx(np.hypot(0.1, 0.1))


def test_a_gap_wider_than_the_disc_is_passed_and_a_narrower_one_is_not() -> None:
    width = 1.0  # width of the doorway at x = 5
    for radius_m, passes in ((0.2, True), (width / 2 - 0.01, True), (width / 2 + 0.01, False)):
        gone = floor_of(hand_house(), radius_m=radius_m).free_way(4.0, 2.0, 2.0, 0.0)
        assert (gone == 2.0) == passes


def test_what_is_removed_or_above_or_below_stands_in_no_way() -> None:
    house = hand_house()
    table = 3
    box = item_box(house.spec.items[table])
    x, y = float(box[0]) - 0.5, float(box[1] + box[4]) / 2
    assert floor_of(house).free_way(x, y, 1.0, 0.0) < 0.5
    assert floor_of(house, Arrangement(removed=(table,))).free_way(x, y, 1.0, 0.0) == 1.0
    for z in (0.0, 1.2):
        ball = PlacedObject("soccer_ball", (x + 0.4, y, z), (0.0, 0.0, 0.0, 1.0), 1, "ontop", table)
        low, high = object_box(ball)[[2, 5]]
        floor = floor_of(house, Arrangement(removed=(table,), objects=(ball,)))
        stands = low < TOP_M and high > BOTTOM_M
        assert (floor.free_way(x, y, 1.0, 0.0) < 1.0) == stands


@pytest.mark.parametrize("rpy", [(0.0, 0.0, 0.4), (np.pi / 2, 0.0, 0.7), (0.3, 0.5, 0.0)])
@pytest.mark.parametrize("category", ["hardback", "soap_bottle"])
def test_tilted_things_are_as_wide_as_their_corners(category: str, rpy: tuple[float, float, float]) -> None:
    """Distances are those to the solid, sampled densely."""
    house, turn = hand_house(), matrix_from_rpy(rpy)
    thing = PlacedObject(category, (7.5, 2.0, 0.4), quat_of_matrix(turn), 1, "ontop", 0)
    floor = floor_of(house, Arrangement(removed=tuple(range(house.n_items)), objects=(thing,)))
    shape, rng = object_solid(thing), np.random.default_rng(0)
    inside = []
    for kind, half, center, axes in zip(shape.kind, shape.half, shape.center, shape.turn, strict=True):
        unit = rng.uniform(-1, 1, (40_000, 3))
        unit[:20_000, rng.integers(0, 3)] = np.sign(unit[:20_000, 0])
        unit = unit[np.hypot(unit[:, 0], unit[:, 1]) <= 1] if kind == CYLINDER else unit
        inside.append((center + (unit * half) @ axes.T) @ object_turn(thing).T + np.array(thing.position))
    solid = np.concatenate(inside)[:, :2]
    for angle in np.arange(0.0, 2 * np.pi, 0.5):
        point = np.array([7.5, 2.0]) + 0.55 * np.array([np.cos(angle), np.sin(angle)])
        true = float(np.hypot(*(solid - point).T).min())
        assert floor.clearance(*point) == pytest.approx(true, abs=0.015)


def test_pybullet_agrees() -> None:
    """Every move agrees within 5 mm, and over 99 % of collisions, in random walks through three homes."""
    apart, flags = [], []
    for episode in load_episodes("mini")[4::16]:
        house, rng = load_house(episode.scene), np.random.default_rng(4)
        floor = floor_of(house, episode.arrangement)
        live = LiveFloor(house, episode.arrangement, RADIUS_M, BOTTOM_M, TOP_M)
        (x, y), yaw = house.grid.xy((episode.start.i, episode.start.j)), 0.0
        for _ in range(120):
            yaw += np.pi / 3 * int(rng.integers(-1, 2)) * (rng.random() < 0.4)
            dx, dy = 0.25 * np.cos(yaw), 0.25 * np.sin(yaw)
            ours, theirs = floor.free_way(x, y, dx, dy), live.free_way(x, y, dx, dy)
            apart.append(abs(ours - theirs))
            flags.append((ours < 0.125, theirs < 0.125))
            x, y = x + ours / 0.25 * dx, y + ours / 0.25 * dy
            assert floor.clearance(x, y) > RADIUS_M - 1e-6
        live.close()
    assert max(apart) < 0.005
    assert 0.1 < np.mean([ours for ours, _ in flags]) < 0.9
    assert np.mean([ours == theirs for ours, theirs in flags]) > 0.99


def test_a_pickle_holds_what_the_floor_is_made_of() -> None:
    episode = load_episodes("mini")[0]
    floor = floor_of(load_house(episode.scene), episode.arrangement)
    data = pickle.dumps(floor)
    again = pickle.loads(data)
    assert len(data) < 20_000
    assert all(np.array_equal(a, b) for a, b in zip(again.tables, floor.tables, strict=True))


PLAY = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "pybullet":
            raise ImportError("blocked")
sys.meta_path.insert(0, Block())
from ucon.envs.ucon_env import UcONEnv
env = UcONEnv("mini", task="real_robot", habit_level="none", observe="symbolic")
env.reset(options={"episode": 0})
for action in (0, 0, 1, 0, 6):
    _, _, over, _, info = env.step(action)
print(over, info["episode_metrics"]["final_distance_m"] > 0, "pybullet" in sys.modules)
"""


def test_compiled_play_never_imports_pybullet() -> None:
    done = subprocess.run([sys.executable, "-c", PLAY], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "True", "False"]
