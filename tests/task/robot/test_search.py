"""How a robot moves: exactly, with errors, and according to its odometry."""

from __future__ import annotations

import copy
from functools import lru_cache

import numpy as np
import pytest

from tests.sim.homes import hand_house
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.actions import Action
from ucon.task.robot.errors import MOVE_AHEAD_M, TURN_YAW_RAD, RobotErrors
from ucon.task.robot.pose import RobotPose, half_turn
from ucon.task.robot.rig import RobotRig, floor_of
from ucon.task.robot.search import RobotSearch
from ucon.task.rules import REAL_ROBOT

AHEAD, RIGHT, LEFT, UP, DOWN, OPEN, DONE = Action
APPLE = PlacedObject("apple", (9.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0), 1, "ontop", 2)


class OpenGround:
    """An endless floor without obstacles."""

    def free_way(self, x: float, y: float, dx: float, dy: float) -> float:
        return float(np.hypot(dx, dy))

    def clearance(self, x: float, y: float) -> float:
        return 0.6


@lru_cache(maxsize=1)
def eyes() -> RasterRenderer:
    return RasterRenderer(fov_deg=60.0, counting_fov_deg=60.0)


def robot(
    rig: RobotRig, episode: str = "e", at: tuple[float, float] = (6.5, 1.0), endless: bool = False
) -> RobotSearch:
    world = SceneState(hand_house(), Arrangement(objects=(APPLE,)))
    eyes().load(world.house, world.arrangement)
    ground = OpenGround() if endless else None
    target = world.house.n_instances
    pose, errors = RobotPose(*at, 0.0), RobotErrors(rig, episode)
    return RobotSearch(world, eyes(), target, pose, REAL_ROBOT, floor_of(world, rig), errors, ground)


def test_six_turns_and_moves_of_an_exact_robot_are_a_hexagon() -> None:
    search = robot(RobotRig.exact(), endless=True)
    for _ in range(6):
        assert not search.step(AHEAD).collision
        search.step(LEFT)
    assert search.xy == pytest.approx((6.5, 1.0))
    assert search.pose.yaw_deg == 0.0
    assert search.moved_m == pytest.approx(1.5)
    assert search.odometry == pytest.approx([0.0, 0.0, 0.0, 0.0], abs=1e-6)


def test_the_frame_of_the_odometry_is_that_of_the_start() -> None:
    search = robot(RobotRig.exact(), endless=True)
    for action in (AHEAD, RIGHT, AHEAD, DOWN):
        search.step(action)
    x, y, yaw, pitch = search.odometry.tolist()
    assert (x, y) == pytest.approx((0.25 + 0.125, -0.25 * np.sqrt(0.75)))
    assert (yaw, pitch) == pytest.approx((-np.pi / 3, -np.pi / 6))


def test_a_move_ends_at_contact_and_is_a_collision_below_half_of_its_way() -> None:
    search = robot(RobotRig.exact())
    gone, collisions = [], []
    for _ in range(20):
        before = search.moved_m
        collisions.append(search.step(AHEAD).collision)
        gone.append(search.moved_m - before)
    assert collisions[-1]
    assert not collisions[0]
    assert [way < 0.125 for way in gone] == collisions
    assert search.floor.clearance(*search.xy) == pytest.approx(search.floor.radius_m, abs=1e-4)


def test_done_succeeds_near_and_in_view() -> None:
    search = robot(RobotRig.exact())
    while np.hypot(search.xy[0] - 9.0, search.xy[1] - 1.0) > 0.9:
        assert not search.target_in_reach()
        search.step(AHEAD)
    search.step(DOWN)
    assert search.target_in_reach()
    search.step(LEFT)
    search.step(LEFT)
    assert not search.target_in_reach()
    search.step(RIGHT)
    search.step(RIGHT)
    assert search.step(DONE).success


def test_errors_have_the_published_size_and_either_sign() -> None:
    errors = RobotErrors(RobotRig(), "sizes")
    moves = np.array([errors.of_move(k).ahead_m for k in range(3000)])
    turns = np.radians([errors.of_turn(k).yaw_deg for k in range(3000)])
    for found, (mean, deviation) in ((moves, MOVE_AHEAD_M), (turns, TURN_YAW_RAD)):
        assert abs(found.mean()) < 0.1 * mean
        assert found.std() == pytest.approx(np.hypot(mean, deviation), rel=0.05)
    twice = RobotErrors(RobotRig(motion_noise=2.0), "sizes")
    assert twice.of_move(5).ahead_m == pytest.approx(2 * moves[5])


def test_errors_of_turns_do_not_add_up_in_the_robots_own_frame() -> None:
    search = robot(RobotRig(), endless=True)
    off = []
    for k in range(120):
        search.step(LEFT if k % 7 else RIGHT)
        yaw = float(np.degrees(search.odometry[2]))
        off.append(abs(half_turn(yaw - 60 * round(yaw / 60))))
    assert max(off) < 5.0
    assert np.mean(off[60:]) == pytest.approx(np.mean(off[:60]), abs=0.5)


def test_odometry_drifts_by_two_metres_in_a_loop_of_120() -> None:
    """A Go2 drifts by 2.21 m (1.8 %) in a loop of 120 m; here the loop is a hexagon of 20 m a side."""
    apart = []
    for number in range(60):
        search = robot(RobotRig(motion_noise=0.0), f"loop {number}", endless=True)
        for _ in range(6):
            for _ in range(80):
                search.step(AHEAD)
            search.step(LEFT)
        x, y = search.odometry[:2].tolist()
        apart.append(np.hypot(search.xy[0] - 6.5 - x, search.xy[1] - 1.0 - y))
    assert np.mean(apart) == pytest.approx(2.21, abs=0.5)
    assert min(apart) < 1.2


def walk(rig: RobotRig, episode: str = "same", steps: int = 60) -> list[tuple[float, ...]]:
    search, rng = robot(rig, episode), np.random.default_rng(0)
    poses = []
    for _ in range(steps):
        search.step(int(rng.choice([0, 0, 0, 1, 2, 3, 4])))
        poses.append((*search.xy, search.pose.yaw_deg, *search.odometry.tolist()))
    return poses


def test_the_same_seed_and_episode_give_the_same_numbers_and_others_do_not() -> None:
    rig = RobotRig()
    assert walk(rig) == walk(rig)
    assert walk(rig) != walk(RobotRig(seed=1))
    assert walk(rig) != walk(rig, "other")


def test_a_copy_goes_its_own_way() -> None:
    search = robot(RobotRig())
    for _ in range(3):
        search.step(AHEAD)
    twin = copy.deepcopy(search)
    search.step(LEFT)
    assert twin.steps == 3
    twin.step(LEFT)
    assert (twin.pose, twin.odometry.tolist()) == (search.pose, search.odometry.tolist())
