"""Errors of a robot's moves, turns and odometry. Every draw is keyed by the rig's seed, the episode and the step.

Moves and turns: the errors measured on a LoCoBot with PyRobot's ILQR controller (Murali et al. 2019, arXiv:1906.08236),
as simulated in the Habitat challenge of 2020. Its file gives a mean and a second number for each error. The challenge
uses the second number as an entry of a covariance, which would make a move of 0.25 m err by 8 cm; here it is the
standard deviation, the mean is the size of a typical error, and both signs are equally likely.

Odometry: its yaw drifts with every move and turn, and its lengths are wrong by a share that is drawn for each episode.
The drift is set so that a walk of 120 m round a hexagon ends 2.21 m (1.8 %) from where it began, as measured with a
Unitree Go2 (arXiv:2602.17393). A closed loop says nothing about the share of the lengths; 1 % is a judgement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ucon.core.rng import derived_seed, stream
from ucon.core.sharing import Shared
from ucon.task.robot.rig import RobotRig

#: Mean and standard deviation of an error's size, metres: along and across the heading, for a move and for a turn.
MOVE_AHEAD_M: Final = (0.014, 0.006)
MOVE_ASIDE_M: Final = (0.009, 0.005)
TURN_AHEAD_M: Final = (0.003, 0.002)
TURN_ASIDE_M: Final = (0.003, 0.003)
#: The same for the yaw, radians.
MOVE_YAW_RAD: Final = (0.008, 0.004)
TURN_YAW_RAD: Final = (0.023, 0.012)
#: Standard deviation of the odometry's yaw drift in one move or turn.
DRIFT_DEG: Final = 0.24
#: Standard deviation of the share by which the odometry's lengths are wrong.
SCALE: Final = 0.01


@dataclass(frozen=True, slots=True)
class Slip(Shared):
    """The error of one move or turn, in the robot's frame, and the part of it that the odometry does not notice."""

    ahead_m: float = 0.0
    aside_m: float = 0.0
    """To the left."""
    yaw_deg: float = 0.0
    """Counter-clockwise."""
    drift_deg: float = 0.0
    """By how much the odometry overestimates the change of the yaw."""


@dataclass(frozen=True, slots=True)
class RobotErrors(Shared):
    """The errors of one rig in one episode."""

    rig: RobotRig
    episode: str
    """Id of the episode."""

    def of_move(self, step: int) -> Slip:
        """The slip of a move ahead at a step."""
        return self._slip(step, MOVE_AHEAD_M, MOVE_ASIDE_M, MOVE_YAW_RAD)

    def of_turn(self, step: int) -> Slip:
        """The slip of a turn at a step."""
        return self._slip(step, TURN_AHEAD_M, TURN_ASIDE_M, TURN_YAW_RAD)

    def scale(self) -> float:
        """Metres that the odometry measures for each metre moved."""
        if self.rig.odometry == "exact":
            return 1.0
        return float(1.0 + SCALE * stream(self.rig.seed, "scale", self.episode).standard_normal())

    def depth_key(self, step: int) -> int:
        """The key of the errors of a step's depth image."""
        return derived_seed(self.rig.seed, "depth", self.episode, step)

    def _slip(
        self, step: int, ahead: tuple[float, float], aside: tuple[float, float], yaw: tuple[float, float]
    ) -> Slip:
        strength, drifts = self.rig.motion_noise, self.rig.odometry == "drift"
        if strength == 0.0 and not drifts:
            return Slip()
        draw = stream(self.rig.seed, "motion", self.episode, step)
        drift_deg = DRIFT_DEG * draw.standard_normal() * drifts
        a, b, c = (_either_side(draw, *size) * strength for size in (ahead, aside, yaw))
        return Slip(a, b, math.degrees(c), drift_deg)


def _either_side(draw: np.random.Generator, mean: float, deviation: float) -> float:
    """An error of about this size, with a random sign."""
    size = draw.normal(mean, deviation)
    return float(size if draw.random() < 0.5 else -size)
