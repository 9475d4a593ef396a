"""Shortest paths and solutions of a robot's episodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ucon.sim.cache import load_house
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.actions import Action
from ucon.task.begin import begun_search
from ucon.task.episode import Episode
from ucon.task.making.make_sets import verify_episode
from ucon.task.robot.pose import start_pose
from ucon.task.robot.rig import RobotRig, floor_of
from ucon.task.robot.search import RobotSearch
from ucon.task.robot.solve import RobotSolver
from ucon.task.rules import REAL_ROBOT
from ucon.task.sets import load_episodes

#: By how much a shortest path may be too long: a cell at each end, and 2.7 % of the way (rounded up).
ENDS_M, SHARE = 0.1, 1.028


def episodes() -> tuple[Episode, ...]:
    return load_episodes("mini", "real_robot")


def begun(episode: Episode) -> RobotSearch:
    world, eyes = SceneState(load_house(episode.scene), episode.arrangement), RasterRenderer(counting_fov_deg=60.0)
    eyes.load(world.house, episode.arrangement)
    search = begun_search(episode, world, eyes, REAL_ROBOT, RobotRig.exact())
    assert isinstance(search, RobotSearch)
    return search


def test_stored_episodes_hold_and_false_ones_do_not() -> None:
    some = episodes()[::7]
    assert [verify_episode(episode) for episode in some] == [""] * len(some)
    episode = some[0]
    wrong = {
        "the solution's Done fails": replace(episode, solution="6"),
        "the solution does not end in Done": replace(episode, solution=episode.solution[:-1]),
        "a shortest path of 0.1 m": replace(episode, shortest_path_m=0.1),
        "a shortest path of 99": replace(episode, shortest_path_m=99.0),
        "is blocked": replace(episode, solution="0" * 200 + "6"),
    }
    for message, changed in wrong.items():
        assert message in verify_episode(changed)


def test_the_set_has_open_and_closed_targets_and_starts_that_are_far() -> None:
    found = episodes()
    assert len(found) == 50
    assert {episode.task for episode in found} == {"real_robot"}
    assert 5 <= sum("5" in episode.solution for episode in found) <= 45
    assert np.mean([episode.shortest_path_m >= 2.0 for episode in found]) > 0.9


@pytest.mark.parametrize("closed", [False, True])
def test_a_solver_finds_the_stored_path_again(closed: bool) -> None:
    episode = min((e for e in episodes() if ("5" in e.solution) == closed), key=lambda e: e.shortest_path_m)
    search = begun(episode)
    world = search.world
    solver = RobotSolver(world, search.eyes, search.target, REAL_ROBOT, floor_of(world, RobotRig.exact()))  # type: ignore[arg-type]
    assert solver.findable
    found = solver.solve(start_pose(world.house, episode.start))
    assert found is not None
    assert (found[0], found[1].digits) == (pytest.approx(episode.shortest_path_m), episode.solution)


def test_no_search_succeeds_by_less_than_the_shortest_path() -> None:
    """Tested on random walks that end as soon as Done would succeed."""
    near = sorted((e for e in episodes() if "5" not in e.solution), key=lambda e: e.shortest_path_m)[:8]
    rng, successes = np.random.default_rng(2), 0
    for episode in near:
        for _ in range(6):
            search = begun(episode)
            for _ in range(150):
                search.step(int(rng.choice([0, 0, 0, 0, 1, 2])))
                near_now = search.metres_to_near(search.target) == 0.0
                if near_now and any(looked(search)):
                    successes += 1
                    assert SHARE * search.moved_m + ENDS_M >= episode.shortest_path_m
                    break
    assert successes >= 5


def looked(search: RobotSearch) -> list[bool]:
    """Whether the target is in reach at each pitch, at this position and yaw; the camera is level again afterwards."""
    found = [search.target_in_reach()]
    for actions in ((Action.LOOK_UP, 2), (Action.LOOK_DOWN, 4)):
        for _ in range(actions[1]):
            search.step(actions[0])
            found.append(search.target_in_reach())
    for _ in range(2):
        search.step(Action.LOOK_UP)
    return found
