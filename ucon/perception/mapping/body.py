"""What an agent knows of its own body: where its camera is, how it looks up and down, how far it reaches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ucon.core.sharing import Shared
from ucon.task.rules import PAPER, TaskRules, task_rules


@dataclass(frozen=True, slots=True)
class Body(Shared):
    """A body under a rule set; rules are public. A *look* is what LookUp and LookDown have come to, 30 an action.

    Under most rules it is the camera's pitch in degrees. Where these actions move the camera instead, a look of 30 is
    the next height above the first one.
    """

    eyes: Mapping[int, tuple[float, int]]
    """Height in metres and pitch in degrees of the camera, for every look; the level one first."""
    searching: tuple[int, ...]
    """Looks that views are valued for; the others serve to look at something known."""
    near_m: float
    """Horizontal distance within which Open and Done act on a thing."""

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
        """The body in the episode whose first ``info`` is given."""
        return cls.under(task_rules(str(info.get("task", PAPER.name))))

    @property
    def camera_m(self) -> float:
        """Height of the camera when it looks level."""
        return self.eyes[0][0]

    def look(self, camera_m: float, pitch_deg: int) -> int:
        """The look by which the camera is where it is."""
        return min(self.eyes, key=lambda k: (abs(self.eyes[k][1] - pitch_deg), abs(self.eyes[k][0] - camera_m)))


PAPER_BODY = Body.under(PAPER)
