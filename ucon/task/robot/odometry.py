"""The robot's own estimate of its pose, in its start frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.sim.render.base import heading_cos_sin
from ucon.task.robot.pose import half_turn


@dataclass(frozen=True, slots=True)
class Odometry(Shared):
    """Where the robot believes it is: metres and degrees relative to its start, x ahead and y to the left."""

    x: float = 0.0
    y: float = 0.0
    yaw_deg: float = 0.0

    def after(self, ahead_m: float, left_m: float, turned_deg: float) -> Odometry:
        """The estimate after a motion, from the measured motion.

        Args:
            ahead_m: metres along the yaw before the motion.
            left_m: metres to the left of it.
            turned_deg: degrees turned counter-clockwise.
        """
        c, s = heading_cos_sin(self.yaw_deg / 90.0)
        x, y = self.x + c * ahead_m - s * left_m, self.y + s * ahead_m + c * left_m
        return Odometry(x, y, (self.yaw_deg + turned_deg) % 360.0)

    def to_next(self, direction: int, turn_deg: int) -> float:
        """Degrees of a turn to the next multiple of ``turn_deg``.

        This keeps the robot at the headings of its own frame: each turn corrects the error of the one before.

        Args:
            direction: 1 to the left, -1 to the right.
            turn_deg: angle of a turn.
        """
        return half_turn((round(self.yaw_deg / turn_deg) + direction) * turn_deg - self.yaw_deg)

    def pose(self, pitch_deg: int) -> NDArray[np.float32]:
        """(4,) float32: x, y in metres, yaw, pitch in radians."""
        return np.array([self.x, self.y, np.radians(half_turn(self.yaw_deg)), np.radians(pitch_deg)], np.float32)
