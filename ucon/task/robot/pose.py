"""The pose of a robot that moves continuously."""

from __future__ import annotations

from dataclasses import dataclass

from ucon.core.sharing import Shared
from ucon.sim.house import House
from ucon.task.episode import Start


@dataclass(frozen=True, slots=True)
class RobotPose(Shared):
    """Position in metres and yaw in degrees in the world frame; camera height index and pitch (up positive)."""

    x: float
    y: float
    yaw_deg: float
    """Counter-clockwise from +x, from 0 up to 360."""
    height: int = 0
    pitch_deg: int = 0

    @property
    def heading(self) -> float:
        """The yaw in quarter turns, as renderers take it."""
        return self.yaw_deg / 90.0


def start_pose(house: House, start: Start) -> RobotPose:
    """The first pose of an episode: the centre of its start node."""
    x, y = house.grid.xy((start.i, start.j)).tolist()
    return RobotPose(x, y, 90.0 * start.heading)


def half_turn(angle_deg: float) -> float:
    """An angle in degrees, wrapped to (-180, 180]."""
    angle = angle_deg % 360.0
    return angle - 360.0 if angle > 180.0 else angle
