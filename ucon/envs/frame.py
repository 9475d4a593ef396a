"""The agent's own frame: origin at the start node, x along the heading it starts with, y to its left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.core.sharing import Shared
from ucon.task.episode import Start
from ucon.task.search import Pose

_YAW_RAD = (0.0, np.pi / 2, np.pi, -np.pi / 2)


@dataclass(frozen=True, slots=True)
class StartFrame(Shared):
    """Turns world nodes and headings into the agent's frame."""

    start: Start

    def pose(self, pose: Pose) -> NDArray[np.float32]:
        """(x, y, yaw, pitch) in metres and radians relative to the start, float32 (4,)."""
        dx, dy = (pose.i - self.start.i) * 0.25, (pose.j - self.start.j) * 0.25
        c, s = HEADING_COS[self.start.heading], HEADING_SIN[self.start.heading]
        yaw = _YAW_RAD[(pose.heading - self.start.heading) % 4]
        return np.array([c * dx + s * dy, c * dy - s * dx, yaw, np.radians(pose.pitch_deg)], np.float32)

    def nodes(self, ahead: NDArray[np.int64], left: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """World nodes i and j of nodes ahead and to the left of the start."""
        c, s = int(HEADING_COS[self.start.heading]), int(HEADING_SIN[self.start.heading])
        return self.start.i + c * ahead - s * left, self.start.j + s * ahead + c * left

    def grid(self, free: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], tuple[int, int]]:
        """The free grid turned into the agent's frame, and the cell of the start node in it."""
        i, j, (nx, ny) = self.start.i, self.start.j, free.shape
        if self.start.heading == 0:
            return free.copy(), (i, j)
        if self.start.heading == 1:
            return np.ascontiguousarray(free[::-1].T), (j, nx - 1 - i)
        if self.start.heading == 2:
            return np.ascontiguousarray(free[::-1, ::-1]), (nx - 1 - i, ny - 1 - j)
        return np.ascontiguousarray(free[:, ::-1].T), (ny - 1 - j, i)
