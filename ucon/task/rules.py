"""The rule sets: ``paper`` (default), ``released_code`` and ``real_robot``.

The released environment differs from the paper in four points: LookUp and LookDown move the camera (0.5 / 1.0 / 1.5 m)
and never pitch it; near means within 0.7 m of the box in x and in y; Open needs no sight of what it opens; Done needs
one pixel of the target's category anywhere in view.

In the paper's real-robot setting the camera stands on rods on the back of a quadruped, its angle of view is 60 degrees,
a turn is 60 degrees, and the robot moves continuously. How exactly it moves and senses is set in its rig, not here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, unknown_name
from ucon.core.sharing import Shared
from ucon.task.actions import Action


@dataclass(frozen=True, slots=True)
class TaskRules(Shared):
    """Every number and switch that decides an episode's outcome."""

    name: str
    max_steps: int = 300
    """Steps after which an episode is truncated."""
    near_m: float = 1.0
    """Reach of Open and Done, metres."""
    near_is_rectangle: bool = False
    """Near means inside the box grown by ``near_m`` in x and y; else the horizontal distance to its nearest point."""
    open_needs_sight: bool = True
    """Whether Open acts only on what is visible."""
    done_min_pixels: int = 4
    """Least pixels of the target in the canonical view: 128 x 128 pixels, ``fov_deg`` wide."""
    done_by_category: bool = False
    """Whether pixels of any object of the target's category count."""
    open_min_pixels: int = 4
    """Least pixels of a container in the canonical view."""
    look_moves_camera: bool = False
    """Whether LookUp and LookDown change the camera's height instead of its pitch."""
    camera_heights_m: tuple[float, ...] = (1.25,)
    """Heights of the camera above the floor."""
    start_height: int = 0
    """Index of the camera height at the start."""
    max_pitch_deg: int = 60
    pitch_step_deg: int = 30
    """Pitch of a LookUp or LookDown, degrees."""
    turn_deg: int = 90
    """Angle of a RotateRight or RotateLeft, degrees."""
    fov_deg: float = 90.0
    """Angle of view, also of the canonical view in which pixels are counted, degrees."""
    continuous: bool = False
    """Whether the robot moves continuously; else from node to node of the 0.25 m grid."""

    def near(self, xy: NDArray[np.float64], boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which boxes are within reach of the agent; heights do not count.

        Args:
            xy: (2,) the agent's position, metres.
            boxes: (n, 6) x0 y0 z0 x1 y1 z1, metres.

        Returns:
            (n,) bool.
        """
        gap_x = np.maximum(np.maximum(boxes[:, 0] - xy[0], xy[0] - boxes[:, 3]), 0.0)
        gap_y = np.maximum(np.maximum(boxes[:, 1] - xy[1], xy[1] - boxes[:, 4]), 0.0)
        if self.near_is_rectangle:
            return (gap_x <= self.near_m + 1e-9) & (gap_y <= self.near_m + 1e-9)
        return gap_x * gap_x + gap_y * gap_y <= self.near_m * self.near_m + 1e-9

    def actions(self) -> list[dict[str, str]]:
        """Name and effect of the seven actions as text, in their order."""
        near = f"within {self.near_m:g} m"
        if self.look_moves_camera:
            look = f"the camera goes to the next height of {', '.join(f'{h:g}' for h in self.camera_heights_m)} m"
        else:
            look = f"{self.pitch_step_deg} degrees, at most {self.max_pitch_deg}"
        seen = f" and shows at least {self.open_min_pixels} pixels" if self.open_needs_sight else ""
        target = "a thing of the target's category" if self.done_by_category else "the target"
        done = f"end; a success if {target} is {near} and shows at least {self.done_min_pixels} pixels"
        effects = (
            "0.25 m ahead, or a collision that costs the step", f"{self.turn_deg} degrees clockwise",
            f"{self.turn_deg} degrees counter-clockwise", f"up: {look}", f"down: {look}",
            f"open every closed thing that is {near}{seen}", done,
        )  # fmt: skip
        names = (action.name.lower().replace("_", " ") for action in Action)
        return [{"name": name, "effect": effect} for name, effect in zip(names, effects, strict=True)]

    def require_grid(self, what: str) -> None:
        """Refuse rules without a grid, for code that works on its nodes only.

        Args:
            what: what is refused and why; begins the message.

        Raises:
            ConfigError: the robot moves continuously under these rules.
        """
        if self.continuous:
            raise ConfigError(f"{what}, but with task={self.name} the robot moves continuously")

    @property
    def headings(self) -> int:
        """Number of headings in a full turn."""
        return 360 // self.turn_deg

    @property
    def views(self) -> tuple[tuple[int, int], ...]:
        """All (height index, pitch in degrees) that the camera can take, the level ones first."""
        if self.look_moves_camera:
            return tuple((h, 0) for h in range(len(self.camera_heights_m)))
        steps = range(0, self.max_pitch_deg + 1, self.pitch_step_deg)
        return tuple((0, p) for step in steps for p in ((-step, step) if step else (0,)))


PAPER = TaskRules("paper")
RELEASED_CODE = TaskRules(
    "released_code",
    near_m=0.7,
    near_is_rectangle=True,
    open_needs_sight=False,
    done_min_pixels=1,
    done_by_category=True,
    look_moves_camera=True,
    camera_heights_m=(0.5, 1.0, 1.5),
    start_height=1,
)
REAL_ROBOT = TaskRules("real_robot", turn_deg=60, fov_deg=60.0, continuous=True, camera_heights_m=(0.9,))
RULES = {rules.name: rules for rules in (PAPER, RELEASED_CODE, REAL_ROBOT)}


def task_rules(name: str, least_pixels: int | None = None) -> TaskRules:
    """The rule set with the given name.

    Args:
        name: of the rule set.
        least_pixels: least pixels for Done and Open, where they require any; None: as in the rule set. Stored episodes
            are solvable under the unchanged rules; with more pixels some may not be.

    Raises:
        ConfigError: there is no such rule set, or ``least_pixels`` is below 1.
    """
    if name not in RULES:
        raise ConfigError(unknown_name("task", name, RULES))
    if least_pixels is None:
        return RULES[name]
    if least_pixels < 1:
        raise ConfigError(f"env.least_pixels={least_pixels}: expected 1 or more, or null for the rule set's own")
    return replace(RULES[name], done_min_pixels=least_pixels, open_min_pixels=least_pixels)
