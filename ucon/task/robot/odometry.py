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
    """Where the robot believes to be: metres and degrees from its start, x ahead and y to the left of it."""

    x: float = 0.0
    y: float = 0.0
    yaw_deg: float = 0.0

    def after(self, ahead_m: float, left_m: float, turned_deg: float) -> Odometry:
        """The estimate after a motion, as it is measured.

        Args:
            ahead_m: along the yaw before it.
            left_m: across it.
            turned_deg: counter-clockwise.
        """
        c, s = heading_cos_sin(self.yaw_deg / 90.0)
        x, y = self.x + c * ahead_m - s * left_m, self.y + s * ahead_m + c * left_m
        return Odometry(x, y, (self.yaw_deg + turned_deg) % 360.0)

    def to_next(self, direction: int, turn_deg: int) -> float:
        """Degrees of a turn to the next multiple of ``turn_deg``.

        So the robot's headings stay those of its own frame: the error of a turn is made good by the next one.

        Args:
            direction: 1 to the left, -1 to the right.
            turn_deg: angle of a turn.
        """
        return half_turn((round(self.yaw_deg / turn_deg) + direction) * turn_deg - self.yaw_deg)

    def pose(self, pitch_deg: int) -> NDArray[np.float32]:
        """(4,) float32: x, y in metres, yaw, pitch in radians."""
        return np.array([self.x, self.y, np.radians(half_turn(self.yaw_deg)), np.radians(pitch_deg)], np.float32)
