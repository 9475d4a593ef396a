"""How a robot's moves, turns and odometry err. Every draw is keyed by the rig's seed, the episode and the step.

Moves and turns: those measured on a LoCoBot with PyRobot's ILQR controller (Murali et al. 2019, arXiv:1906.08236), as
the Habitat challenge of 2020 plays them. Its file gives a mean and a second number for each error. It is used as the
entry of a covariance there, which would make a move of 0.25 m err by 8 cm; here it is the standard deviation, the mean
is the size of a typical error, and either side is as likely.

Odometry: its yaw drifts with every move and turn, its metres are wrong by a share that is drawn for each episode. The
drift is set so that a walk of 120 m round a hexagon ends 2.21 m (1.8 %) from where it began, as measured with a Unitree
Go2 (arXiv:2602.17393). A loop says nothing about the share; 1 % is a judgement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from ucon.core.rng import derived_seed, stream
from ucon.core.sharing import Shared
from ucon.task.robot.rig import RobotRig

#: Mean and standard deviation of an error's size, metres: along and across the way, of a move and of a turn.
MOVE_AHEAD_M: Final = (0.014, 0.006)
MOVE_ASIDE_M: Final = (0.009, 0.005)
TURN_AHEAD_M: Final = (0.003, 0.002)
TURN_ASIDE_M: Final = (0.003, 0.003)
#: The same of the yaw, radians.
MOVE_YAW_RAD: Final = (0.008, 0.004)
TURN_YAW_RAD: Final = (0.023, 0.012)
#: Standard deviation of the odometry's yaw drift in one move or turn.
DRIFT_DEG: Final = 0.24
#: Standard deviation of the share by which its metres are wrong.
SCALE: Final = 0.01


@dataclass(frozen=True, slots=True)
class Slip(Shared):
    """What a move or turn does beside what was wanted, in the robot's frame, and what of it goes unnoticed."""

    ahead_m: float = 0.0
    aside_m: float = 0.0
    """To the left."""
    yaw_deg: float = 0.0
    """Counter-clockwise."""
    drift_deg: float = 0.0
    """By how much the odometry mistakes the change of the yaw."""


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
        """What the odometry takes a metre for."""
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
    """An error of about this size, to either side."""
    size = draw.normal(mean, deviation)
    return float(size if draw.random() < 0.5 else -size)
