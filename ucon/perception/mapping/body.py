"""What an agent knows of its own body: camera height, camera pitch, and how far it reaches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.task.rules import PAPER, TaskRules, task_rules

#: Twice the standard error of a stereo camera's depth of 1 m: .08 pixels of disparity, 50 mm between the lenses, a
#: focal length of 424 pixels (Intel RealSense D435).
_BLUR: Final = 2.0 * 0.08 / (0.05 * 424.0)
#: Four in five points of a cell of 0.25 m are nearer to its middle than this.
_OFF_NODE_M: Final = 0.125


@dataclass(frozen=True, slots=True)
class Body(Shared):
    """The agent's body under a rule set; rules are public.

    A *look* is the sum of the LookUp and LookDown actions so far, 30 each. Under most rules it is the camera's pitch in
    degrees. Under rules where these actions move the camera, a look of 30 is the next height above the first one.
    """

    eyes: Mapping[int, tuple[float, int]]
    """By look: the camera's height in metres and pitch in degrees; the level look comes first."""
    searching: tuple[int, ...]
    """The looks that a search chooses among; the others are used only to face a thing that was seen."""
    near_m: float
    """Horizontal distance in metres within which Open and Done act on a thing."""
    headings: int = 4
    """Headings of a full turn; a view is as wide as one rotation (:mod:`ucon.core.compass`)."""
    exact: bool = True
    """Whether the agent stands on nodes of the grid and measures without error; False for the real robot."""
    blur: float = 0.0
    """Depth in metres may be wrong by this times its square (twice the standard error)."""

    @classmethod
    def under(cls, rules: TaskRules) -> Body:
        """The body under a rule set."""
        if rules.look_moves_camera:
            first = rules.start_height
            order = sorted(range(len(rules.camera_heights_m)), key=lambda h: (abs(h - first), h))
            eyes = {30 * (h - first): (rules.camera_heights_m[h], 0) for h in order}
            return cls(eyes, (0,), rules.near_m, rules.headings, not rules.continuous, _BLUR * rules.continuous)
        height_m = rules.camera_heights_m[rules.start_height]
        eyes = {pitch: (height_m, pitch) for _, pitch in rules.views}
        return cls(eyes, tuple(eyes), rules.near_m, rules.headings, not rules.continuous, _BLUR * rules.continuous)

    @classmethod
    def of(cls, info: Mapping[str, Any]) -> Body:
        """The body in an episode, from the info at its reset; under the paper's rules where that has no ``task``."""
        rules = task_rules(str(info.get("task", PAPER.name)))
        if rules.continuous and "camera_m" in info:  # an option of the robot's rig
            rules = replace(rules, camera_heights_m=(float(info["camera_m"]),))
        return cls.under(rules)

    @property
    def off_node_m(self) -> float:
        """How far from the middle of its node the agent usually stands, metres; 0 on the grid."""
        return 0.0 if self.exact else _OFF_NODE_M

    @property
    def fov_deg(self) -> float:
        """Width of a view in degrees."""
        return 360.0 / self.headings

    @property
    def camera_m(self) -> float:
        """Height of the camera above the floor in metres, at a level look."""
        return self.eyes[0][0]

    def farthest(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """The greatest distance at which what each pixel shows may be, within the camera's error.

        Args:
            depth: (H, W) metres along the optical axis.
        """
        return depth + np.float32(self.blur) * depth * depth if self.blur else depth

    def look(self, camera_m: float, pitch_deg: int) -> int:
        """The look that belongs to a camera pose, the nearest one where none fits exactly.

        Args:
            camera_m: height of the camera in metres.
            pitch_deg: pitch in degrees, up positive.
        """
        return min(self.eyes, key=lambda k: (abs(self.eyes[k][1] - pitch_deg), abs(self.eyes[k][0] - camera_m)))


PAPER_BODY = Body.under(PAPER)
