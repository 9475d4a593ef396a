"""The state of a running search by a robot that moves continuously."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.sim.render.base import heading_cos_sin
from ucon.sim.robot.floor import Floor
from ucon.task.robot.pose import RobotPose, half_turn
from ucon.task.rules import TaskRules
from ucon.task.search import Eyes, SceneWorld, Search

#: Length of a MoveAhead, metres.
MOVE_M = 0.25
#: A move that got less far than this share of its way is a collision.
COLLISION_SHARE = 0.5


class RobotSearch(Search):
    """As :class:`ucon.task.search.Search`, with a pose in metres and degrees.

    A move ahead ends where the body touches something.

    Attributes:
        pose: the robot's true pose.
        moved_m: metres moved so far.
    """

    _shared: ClassVar[frozenset[str]] = Search._shared | {"floor", "_first"}
    pose: RobotPose  # type: ignore[assignment]  # it stands between nodes

    def __init__(
        self, world: SceneWorld, eyes: Eyes, target: int, start: RobotPose, rules: TaskRules, floor: Floor
    ) -> None:
        """Start a search.

        Args:
            world: the home and what was placed in it.
            eyes: the renderer, loaded with it.
            target: instance of the target.
            start: the robot's first pose.
            rules: the rule set.
            floor: what the robot can touch.
        """
        super().__init__(world, eyes, target, start, rules)  # type: ignore[arg-type]
        self.floor, self._first = floor, start
        self.moved_m = 0.0

    @property
    def xy(self) -> tuple[float, float]:
        """Position of the robot, metres in the world frame."""
        return self.pose.x, self.pose.y

    @property
    def odometry(self) -> NDArray[np.float32]:
        """(4,) float32: x, y in metres, yaw, pitch in radians, relative to the start, as the robot estimates it."""
        first, here = self._first, self.pose
        c, s = heading_cos_sin(first.heading)
        dx, dy = here.x - first.x, here.y - first.y
        yaw = np.radians(half_turn(here.yaw_deg - first.yaw_deg))
        return np.array([c * dx + s * dy, c * dy - s * dx, yaw, np.radians(here.pitch_deg)], np.float32)

    def _move(self) -> bool:
        """Move ahead; whether it got at least half of the way."""
        return self._shift(MOVE_M, 0.0) >= COLLISION_SHARE

    def _turn(self, direction: int) -> None:
        """Turn to the left (1) or to the right (-1)."""
        yaw = (self.pose.yaw_deg + direction * self.rules.turn_deg) % 360.0
        self._go(replace(self.pose, yaw_deg=yaw))

    def _shift(self, ahead_m: float, left_m: float) -> float:
        """Move along the yaw and across it until something is touched; the share of the way that was possible."""
        c, s = heading_cos_sin(self.pose.heading)
        dx, dy = c * ahead_m - s * left_m, s * ahead_m + c * left_m
        way = math.hypot(dx, dy)
        if way == 0.0:
            return 1.0
        free = self.floor.free_way(self.pose.x, self.pose.y, dx, dy)
        share = free / way
        self.moved_m += free
        self._go(replace(self.pose, x=self.pose.x + share * dx, y=self.pose.y + share * dy))
        return share

    def _look(self, direction: int) -> None:
        """Raise (1) or lower (-1) the camera's pitch."""
        pitch = self.pose.pitch_deg + direction * self.rules.pitch_step_deg
        self._go(replace(self.pose, pitch_deg=min(max(pitch, -self.rules.max_pitch_deg), self.rules.max_pitch_deg)))

    def _go(self, pose: RobotPose) -> None:
        """Take a pose."""
        self.pose = pose
        self._counts = None
