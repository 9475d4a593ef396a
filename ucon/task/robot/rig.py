"""The rig: a quadruped with a camera on four rods on its back, and how exactly it moves and senses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, Literal

from ucon.core.errors import ConfigError, brief
from ucon.core.sharing import Shared
from ucon.sim.robot.floor import Floor
from ucon.task.search import SceneWorld

#: Greatest height that the robot steps over, metres; the same as on the navigation grid.
STEP_OVER_M: Final = 0.05
#: Height of the rig's highest point above the camera, metres.
ABOVE_CAMERA_M: Final = 0.1
#: Greatest radius: homes leave passages for a radius of 0.18 m, and furniture shuts in a body wider than this.
WIDEST_M: Final = 0.3
#: Least radius: thinner than the rods that carry the camera.
_THINNEST_M: Final = 0.01
_HIGHEST_M: Final = 1.8


@dataclass(frozen=True, slots=True)
class RobotRig(Shared):
    """How the robot is built, and how exactly it moves and senses; ``docs/task.md`` has the sources.

    Raises:
        ConfigError: such a rig cannot be built.
    """

    camera_m: float = 0.9
    """Height of the camera above the floor: rods of 0.5 m on the back of a small quadruped."""
    radius_m: float = 0.18
    """Radius of the upright cylinder that models the body, metres; it reaches a little higher than the camera."""
    motion_noise: float = 1.0
    """Strength of the errors of moves and turns: 1 for the published ones, 0 for none."""
    odometry: Literal["drift", "exact"] = "drift"
    """Whether the pose is the robot's own estimate, which drifts, or the true one."""
    depth: Literal["stereo", "exact"] = "stereo"
    """Whether depth has the range, noise and shadows of a stereo camera, or is exact."""
    seed: int = 0
    """Seed of all errors, which also depend on the episode and the step."""

    def __post_init__(self) -> None:
        low, high = STEP_OVER_M + ABOVE_CAMERA_M, _HIGHEST_M - ABOVE_CAMERA_M
        _check("camera_m", self.camera_m, low, high, "metres above the floor")
        _check("radius_m", self.radius_m, _THINNEST_M, WIDEST_M, "metres, which homes leave room for")
        _check("motion_noise", self.motion_noise, 0.0, 10.0, "times the published errors")
        if type(self.seed) is not int or self.seed < 0:
            raise ConfigError(f"rig.seed={brief(self.seed)}: expected a whole number from 0 up")
        for name, known in (("odometry", ("drift", "exact")), ("depth", ("stereo", "exact"))):
            if getattr(self, name) not in known:
                raise ConfigError(f"rig.{name}={brief(getattr(self, name))}: expected {' or '.join(known)}")

    @classmethod
    def exact(cls, **given: Any) -> RobotRig:
        """A rig without errors: exact moves and turns, true pose, true depth.

        Args:
            **given: its other fields.
        """
        return cls(motion_noise=0.0, odometry="exact", depth="exact", **given)

    @property
    def top_m(self) -> float:
        """Highest point of the rig, metres."""
        return self.camera_m + ABOVE_CAMERA_M


def _check(name: str, value: Any, least: float, most: float, unit: str) -> None:
    """Refuse a number that is out of range."""
    number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    if not number or not least <= value <= most:
        raise ConfigError(f"rig.{name}={brief(value)}: expected {least:g} to {most:g} {unit}")


def floor_of(world: SceneWorld, rig: RobotRig) -> Floor:
    """The floor of a world for a robot of this rig."""
    return Floor(world.house, world.arrangement, rig.radius_m, STEP_OVER_M, rig.top_m)
