"""The state of a running search: the agent's pose, what was opened, and the effect of a step.

A search moves an agent on the grid of a :class:`SceneWorld` (compiled arrays or the live PyBullet client) and asks a
renderer what is visible. The environments add observations; the sampler and the oracle use a search directly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.task.actions import AHEAD, Action
from ucon.task.rules import PAPER, TaskRules


class SceneWorld(Protocol):
    """What a search needs from the world, which is compiled arrays or PyBullet."""

    house: House
    arrangement: Arrangement
    categories: tuple[str, ...]
    """Category of each of the n instances."""
    boxes: NDArray[np.float64]
    """(n, 6) boxes in the world frame with joints closed, x0 y0 z0 x1 y1 z1 in metres."""
    openable: NDArray[np.bool_]
    """(n,) instances that Open acts on."""
    free: NDArray[np.bool_]
    """(nx, ny) nodes where the agent can stand."""

    def set_open(self, instance: int, is_open: bool = True) -> None:
        """Open or close an instance."""


class Eyes(Protocol):
    """What the rules need from a renderer."""

    def set_open(self, instance: int, fraction: float) -> None:
        """Show an instance opened by a fraction from 0 to 1."""

    def visible(self, x: float, y: float, z: float, heading: float, pitch_deg: int) -> NDArray[np.int32]:
        """Pixels of every instance in the canonical view.

        Args:
            x: of the camera, metres in the world frame.
            y: of the camera.
            z: of the camera.
            heading: quarter turns.
            pitch_deg: degrees, up positive.

        Returns:
            (n,) int32.
        """


@dataclass(frozen=True, slots=True)
class Pose(Shared):
    """The agent's pose: node, heading in quarter turns, camera height index, pitch in degrees (up positive)."""

    i: int
    j: int
    heading: int
    height: int = 0
    pitch_deg: int = 0


@dataclass(slots=True)
class StepOutcome:
    """The effect of one action.

    Attributes:
        collision: a move was blocked.
        opened: instances that Open opened.
        done: Done was called.
        success: Done succeeded.
    """

    collision: bool = False
    opened: tuple[int, ...] = ()
    done: bool = False
    success: bool = False


class Search(PartlyShared):
    """A running search.

    Attributes:
        world: the home and what was placed in it.
        eyes: the renderer.
        target: instance of the target.
        rules: the rule set.
        pose: the agent's pose.
        opened: (n,) bool, instances that were opened.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"rules", "pose", "_alike", "_free", "_near_boxes", "_counts"})

    def __init__(self, world: SceneWorld, eyes: Eyes, target: int, start: Pose, rules: TaskRules = PAPER) -> None:
        """Start a search.

        Args:
            world: the home and what was placed in it.
            eyes: the renderer, with this world loaded.
            target: instance of the target.
            start: the agent's first pose.
            rules: the rule set.
        """
        self.world, self.eyes, self.target, self.rules = world, eyes, target, rules
        self.pose = start
        self.opened = np.zeros(len(world.boxes), bool)
        self._alike = [target]
        if rules.done_by_category:
            categories = world.house.categories + tuple(o.category for o in world.arrangement.objects)
            self._alike = [k for k, name in enumerate(categories) if name == categories[target]]
        self._counts: NDArray[np.int32] | None = None
        self._free = world.free
        self._near_boxes = world.boxes

    @property
    def camera(self) -> tuple[float, float, float, float, int]:
        """x, y, z (metres, world frame), heading in quarter turns, pitch in degrees: the renderer's arguments."""
        x, y = self.xy
        return x, y, self.rules.camera_heights_m[self.pose.height], self.pose.heading, self.pose.pitch_deg

    @property
    def xy(self) -> tuple[float, float]:
        """Position of the agent, metres in the world frame."""
        origin = self.world.house.grid.origin_xy
        return origin[0] + (self.pose.i + 0.5) * 0.25, origin[1] + (self.pose.j + 0.5) * 0.25

    @property
    def counts(self) -> NDArray[np.int32]:
        """(n,) pixels of every instance in the canonical view from the current pose; computed once per step."""
        if self._counts is None:
            self._counts = self.eyes.visible(*self.camera)
        return self._counts

    def saw(self, counts: NDArray[np.int32]) -> None:
        """Set the canonical pixel counts (n,) of the current pose, from a frame that was rendered anyway."""
        self._counts = counts

    def step(self, action: int) -> StepOutcome:
        """Carry out one action.

        Raises:
            ValueError: not an action.
        """
        outcome = StepOutcome()
        if action == Action.MOVE_AHEAD:
            outcome.collision = not self._move()
        elif action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            self._turn(1 if action == Action.ROTATE_LEFT else -1)
        elif action in (Action.LOOK_UP, Action.LOOK_DOWN):
            self._look(1 if action == Action.LOOK_UP else -1)
        elif action == Action.OPEN:
            outcome.opened = self._open()
        elif action == Action.DONE:
            outcome.done, outcome.success = True, self.target_in_reach()
        else:
            raise ValueError(f"action {action!r}, expected 0 to 6")
        return outcome

    def target_visible(self) -> bool:
        """Whether the canonical view has enough pixels of the target."""
        return bool(max(self.counts[k] for k in self._alike) >= self.rules.done_min_pixels)

    def target_in_reach(self) -> bool:
        """Whether Done would succeed now."""
        near = self.rules.near(np.asarray(self.xy), self._near_boxes[self.target : self.target + 1])
        return bool(near[0]) and self.target_visible()

    def metres_to_near(self, instance: int) -> float:
        """Straight-line metres until an instance is within reach; 0 if it already is."""
        x, y = self.xy
        box = self._near_boxes[instance]
        gap_x, gap_y = max(box[0] - x, x - box[3], 0.0), max(box[1] - y, y - box[4], 0.0)
        return max(math.hypot(gap_x, gap_y) - self.rules.near_m, 0.0)

    def would_open(self) -> tuple[int, ...]:
        """The instances that Open would open now, ascending."""
        candidates = np.flatnonzero(self.world.openable & ~self.opened)
        near = self.rules.near(np.asarray(self.xy), self._near_boxes[candidates])
        candidates = candidates[near]
        if self.rules.open_needs_sight and len(candidates):
            candidates = candidates[self.counts[candidates] >= self.rules.open_min_pixels]
        return tuple(int(k) for k in candidates)

    def _open(self) -> tuple[int, ...]:
        """Open what can be opened, and return the instances."""
        instances = self.would_open()
        for instance in instances:
            self.opened[instance] = True
            self.world.set_open(instance, True)
            self.eyes.set_open(instance, 1.0)
        if instances:
            self._counts = None
        return instances

    def _move(self) -> bool:
        """Move ahead, and return whether that was possible."""
        di, dj = AHEAD[self.pose.heading]
        i, j = self.pose.i + di, self.pose.j + dj
        nx, ny = self._free.shape
        if not (0 <= i < nx and 0 <= j < ny and self._free[i, j]):
            return False
        self._set_pose(i=i, j=j)
        return True

    def _turn(self, direction: int) -> None:
        """Turn to the left (1) or to the right (-1)."""
        self._set_pose(heading=(self.pose.heading + direction) % 4)

    def _look(self, direction: int) -> None:
        """Raise (1) or lower (-1) the camera's pitch or height."""
        rules, pose = self.rules, self.pose
        if rules.look_moves_camera:
            height = min(max(pose.height + direction, 0), len(rules.camera_heights_m) - 1)
            self._set_pose(height=height)
        else:
            pitch = pose.pitch_deg + direction * rules.pitch_step_deg
            self._set_pose(pitch_deg=min(max(pitch, -rules.max_pitch_deg), rules.max_pitch_deg))

    def _set_pose(
        self,
        i: int | None = None,
        j: int | None = None,
        heading: int | None = None,
        height: int | None = None,
        pitch_deg: int | None = None,
    ) -> None:
        """Change some fields of the pose."""
        old = self.pose
        self.pose = Pose(
            old.i if i is None else i,
            old.j if j is None else j,
            old.heading if heading is None else heading,
            old.height if height is None else height,
            old.pitch_deg if pitch_deg is None else pitch_deg,
        )
        self._counts = None
