"""Begins the search of an episode, by an agent on the grid or by a robot."""

from __future__ import annotations

from typing import Any

from ucon.core.errors import EpisodeError
from ucon.sim.robot.floor_kernels import TOUCH_M
from ucon.task.episode import Episode
from ucon.task.robot.errors import RobotErrors
from ucon.task.robot.pose import start_pose
from ucon.task.robot.rig import STEP_OVER_M, RobotRig, floor_of
from ucon.task.robot.search import RobotSearch
from ucon.task.rules import TaskRules
from ucon.task.search import Eyes, Pose, Search


def begun_search(episode: Episode, world: Any, eyes: Eyes, rules: TaskRules, rig: RobotRig | None = None) -> Search:
    """A new search of an episode, before its first step.

    Args:
        episode: the episode.
        world: its home with its arrangement, compiled or in PyBullet.
        eyes: a renderer with this world loaded.
        rules: the rule set.
        rig: the robot's rig, under rules with a robot; None: the default rig.

    Raises:
        EpisodeError: the robot is too wide for the start.
    """
    start, target = episode.start, world.house.n_instances + episode.target
    if not rules.continuous:
        return Search(world, eyes, target, Pose(start.i, start.j, start.heading, rules.start_height, 0), rules)
    rig = rig or RobotRig()
    pose, floor = start_pose(world.house, start), floor_of(world, rig)
    if floor.clearance(pose.x, pose.y) < rig.radius_m - TOUCH_M:
        raise EpisodeError(
            f"episode {episode.id}: a body of radius {rig.radius_m:g} m touches something at the start; give the rig a "
            "smaller radius_m, or make episodes for it"
        )
    ground = world.floor(rig.radius_m, STEP_OVER_M, rig.top_m) if hasattr(world, "floor") else None  # PyBullet's
    return RobotSearch(world, eyes, target, pose, rules, floor, RobotErrors(rig, episode.id), ground)
