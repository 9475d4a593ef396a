"""What an agent knows of its own body: camera height, camera pitch, and how far it reaches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ucon.core.sharing import Shared
from ucon.task.rules import PAPER, TaskRules, task_rules


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

    @classmethod
    def under(cls, rules: TaskRules) -> Body:
        """The body under a rule set."""
        if rules.look_moves_camera:
            first = rules.start_height
            order = sorted(range(len(rules.camera_heights_m)), key=lambda h: (abs(h - first), h))
            eyes = {30 * (h - first): (rules.camera_heights_m[h], 0) for h in order}
            return cls(eyes, (0,), rules.near_m)
        height_m = rules.camera_heights_m[rules.start_height]
        eyes = {pitch: (height_m, pitch) for _, pitch in rules.views}
        return cls(eyes, tuple(eyes), rules.near_m)

    @classmethod
    def of(cls, info: Mapping[str, Any]) -> Body:
        """The body in the episode whose info at the reset is given; without ``task`` in it, under the paper's rules."""
        return cls.under(task_rules(str(info.get("task", PAPER.name))))

    @property
    def camera_m(self) -> float:
        """Height of the camera above the floor in metres, at a level look."""
        return self.eyes[0][0]

    def look(self, camera_m: float, pitch_deg: int) -> int:
        """The look that belongs to a camera pose, the nearest one where none fits exactly.

        Args:
            camera_m: height of the camera in metres.
            pitch_deg: pitch in degrees, up positive.
        """
        return min(self.eyes, key=lambda k: (abs(self.eyes[k][1] - pitch_deg), abs(self.eyes[k][0] - camera_m)))


PAPER_BODY = Body.under(PAPER)
