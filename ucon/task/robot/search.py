"""The state of a running search by a robot that moves continuously."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.sim.render.base import heading_cos_sin
from ucon.sim.robot.floor import Floor, Ground
from ucon.task.robot.errors import RobotErrors
from ucon.task.robot.odometry import Odometry
from ucon.task.robot.pose import RobotPose
from ucon.task.rules import TaskRules
from ucon.task.search import Eyes, SceneWorld, Search, StepOutcome

#: Length of a MoveAhead, metres.
MOVE_M = 0.25
#: A move that covers less than this share of its length is a collision.
COLLISION_SHARE = 0.5


class RobotSearch(Search):
    """Like :class:`ucon.task.search.Search`, with a pose in metres and degrees.

    A move ahead ends where the body touches something. A turn goes to the next multiple of 60 degrees in the robot's
    own frame, as measured by its odometry.

    Attributes:
        pose: the robot's true pose.
        moved_m: metres moved so far.
        steps: actions so far.
        floor: what the robot can touch, compiled.
    """

    _shared: ClassVar[frozenset[str]] = Search._shared | {"floor", "errors", "_odometry", "_ground", "_scale"}
    pose: RobotPose  # type: ignore[assignment]  # not tied to nodes

    def __init__(
        self,
        world: SceneWorld,
        eyes: Eyes,
        target: int,
        start: RobotPose,
        rules: TaskRules,
        floor: Floor,
        errors: RobotErrors,
        ground: Ground | None = None,
    ) -> None:
        """Start a search.

        Args:
            world: the home and what was placed in it.
            eyes: the renderer, with this world loaded.
            target: instance of the target.
            start: the robot's first pose.
            rules: the rule set.
            floor: what the robot can touch.
            errors: errors of the robot's motion and senses.
            ground: moves the robot in place of ``floor``; PyBullet's.
        """
        super().__init__(world, eyes, target, start, rules)  # type: ignore[arg-type]
        self.floor, self.errors = floor, errors
        self._ground = ground or floor
        self._odometry, self._scale = Odometry(), errors.scale()
        self.moved_m, self.steps = 0.0, 0

    @property
    def xy(self) -> tuple[float, float]:
        """Position of the robot, metres in the world frame."""
        return self.pose.x, self.pose.y

    @property
    def odometry(self) -> NDArray[np.float32]:
        """(4,) float32: x, y in metres, yaw, pitch in radians, relative to the start, as the robot estimates it."""
        return self._odometry.pose(self.pose.pitch_deg)

    def step(self, action: int) -> StepOutcome:
        """Carry out one action.

        Raises:
            ValueError: not an action.
        """
        outcome = super().step(action)
        self.steps += 1
        return outcome

    def _move(self) -> bool:
        """Move ahead, and return whether at least half of the move was possible."""
        slip = self.errors.of_move(self.steps)
        return self._go(MOVE_M + slip.ahead_m, slip.aside_m, slip.yaw_deg, slip.drift_deg) >= COLLISION_SHARE

    def _turn(self, direction: int) -> None:
        """Turn to the left (1) or to the right (-1), until the odometry measures the next heading."""
        slip = self.errors.of_turn(self.steps)
        turned_deg = self._odometry.to_next(direction, self.rules.turn_deg) + slip.yaw_deg
        self._go(slip.ahead_m, slip.aside_m, turned_deg, slip.drift_deg)

    def _go(self, ahead_m: float, left_m: float, turned_deg: float, drift_deg: float) -> float:
        """Move ahead and to the left until something is touched, and turn.

        Args:
            ahead_m: metres along the yaw.
            left_m: metres to the left of it.
            turned_deg: change of the yaw as the odometry measures it.
            drift_deg: by how much this exceeds the true change.

        Returns:
            The share of the move that was possible.
        """
        pose, way = self.pose, math.hypot(ahead_m, left_m)
        c, s = heading_cos_sin(pose.heading)
        dx, dy = c * ahead_m - s * left_m, s * ahead_m + c * left_m
        free_m = self._ground.free_way(pose.x, pose.y, dx, dy) if way else 0.0
        share = free_m / way if way else 1.0
        yaw_deg = (pose.yaw_deg + turned_deg - drift_deg) % 360.0
        measured = share * self._scale
        self._odometry = self._odometry.after(measured * ahead_m, measured * left_m, turned_deg)
        self.moved_m += free_m
        self._take(replace(pose, x=pose.x + share * dx, y=pose.y + share * dy, yaw_deg=yaw_deg))
        return share

    def _look(self, direction: int) -> None:
        """Raise (1) or lower (-1) the camera's pitch."""
        pitch = self.pose.pitch_deg + direction * self.rules.pitch_step_deg
        self._take(replace(self.pose, pitch_deg=min(max(pitch, -self.rules.max_pitch_deg), self.rules.max_pitch_deg)))

    def _take(self, pose: RobotPose) -> None:
        """Take a pose."""
        self.pose = pose
        self._counts = None
