"""What is different in an environment under ``task=real_robot``."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.sim.render.base import tan_half
from ucon.sim.robot.stereo import stereo
from ucon.task.episode import Episode
from ucon.task.ledger import Ledger
from ucon.task.robot.ledger import RobotLedger
from ucon.task.robot.rig import RobotRig
from ucon.task.robot.search import RobotSearch
from ucon.task.rules import TaskRules, task_rules
from ucon.task.search import Search


def rigged_rules(task: str, rig: RobotRig | None, least_pixels: int | None = None) -> tuple[TaskRules, RobotRig | None]:
    """The rules of a task, with the camera of the rig, and the rig.

    Args:
        task: name of the rule set.
        rig: as given; None: the default, if the rules have a robot.
        least_pixels: least pixels for Open and Done; None: the rules' own.

    Returns:
        The rig is None under rules without a robot.

    Raises:
        ConfigError: an unknown task, or a rig under rules without a robot.
    """
    rules = task_rules(task, least_pixels)
    if not rules.continuous:
        if rig is not None:
            raise ConfigError(f"env.rig: only for task=real_robot, but this is task={task}; leave it out")
        return rules, None
    rig = rig or RobotRig()
    return replace(rules, camera_heights_m=(rig.camera_m,)), rig


def checked_planner(planner: str | None, rules: TaskRules) -> Literal["true", "observed"]:
    """Check the value of ``planner`` and fill in its default.

    Args:
        planner: as given; None: ``true`` if the rules have a grid.
        rules: rules of the task.

    Raises:
        ConfigError: ``true`` under rules without a grid.
    """
    if rules.continuous and planner == "true":
        raise ConfigError(
            f"env.planner=true: a robot of task={rules.name} moves continuously and no true grid of nodes is given; "
            "leave it at observed"
        )
    return "observed" if rules.continuous or planner == "observed" else "true"


def read_depth(search: RobotSearch, depth: NDArray[np.float32], fov_deg: float) -> None:
    """Turn true depth into the reading of the robot's camera at this step.

    Args:
        search: search of the robot.
        depth: (H, W) metres, overwritten; 0 where there is no reading.
        fov_deg: horizontal angle of view.
    """
    if search.errors.rig.depth == "stereo":
        stereo(depth, search.errors.depth_key(search.steps), 0.5 * depth.shape[1] / tan_half(fov_deg))


def new_ledger(episode: Episode, search: Search) -> Ledger:
    """The metrics of a search, at its beginning."""
    return RobotLedger(episode, search) if isinstance(search, RobotSearch) else Ledger(episode, search)
