"""The agent's start frame: origin at the start node, x along its first heading, y to the left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.core.sharing import Shared
from ucon.scenes.spec import GRID_M
from ucon.sim.navgrid import NavGrid
from ucon.task.episode import Start
from ucon.task.robot.pose import half_turn
from ucon.task.search import Pose


@dataclass(frozen=True, slots=True)
class StartFrame(Shared):
    """Converts world nodes and headings into the start frame."""

    start: Start

    def pose(self, pose: Pose) -> NDArray[np.float32]:
        """A pose in the start frame.

        Args:
            pose: world node, heading and pitch.

        Returns:
            (4,) float32: x, y in metres, yaw, pitch in radians.
        """
        return self.place(pose.i, pose.j, 90 * pose.heading, pose.pitch_deg)

    def place(self, i: int, j: int, yaw_deg: float, pitch_deg: int) -> NDArray[np.float32]:
        """The pose at a world node in the start frame, in the form of :meth:`pose`.

        Args:
            i: first index of the world node.
            j: second index of the world node.
            yaw_deg: yaw in the world frame.
            pitch_deg: pitch, up positive.
        """
        dx, dy = (i - self.start.i) * GRID_M, (j - self.start.j) * GRID_M
        c, s = HEADING_COS[self.start.heading], HEADING_SIN[self.start.heading]
        yaw = np.radians(half_turn(yaw_deg - 90 * self.start.heading))
        return np.array([c * dx + s * dy, c * dy - s * dx, yaw, np.radians(pitch_deg)], np.float32)

    def point(self, xyz: NDArray[np.float64], grid: NavGrid) -> NDArray[np.float64]:
        """A world point in the start frame.

        Args:
            xyz: (3,) metres in the world frame.
            grid: grid of the home.

        Returns:
            (3,) metres.
        """
        dx, dy = xyz[:2] - grid.xy((self.start.i, self.start.j))
        c, s = HEADING_COS[self.start.heading], HEADING_SIN[self.start.heading]
        return np.array([c * dx + s * dy, c * dy - s * dx, xyz[2]])

    def nodes(self, ahead: NDArray[np.int64], left: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """World nodes of nodes given in the start frame.

        Args:
            ahead: (n,) nodes along x.
            left: (n,) nodes along y.

        Returns:
            World i and j, (n,) each.
        """
        c, s = int(HEADING_COS[self.start.heading]), int(HEADING_SIN[self.start.heading])
        return self.start.i + c * ahead - s * left, self.start.j + s * ahead + c * left

    def grid(self, free: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], tuple[int, int]]:
        """A grid over the world, turned into the start frame.

        Args:
            free: (nx, ny) bool by world node.

        Returns:
            The turned grid, and the row and column of the start in it.
        """
        i, j, (nx, ny) = self.start.i, self.start.j, free.shape
        if self.start.heading == 0:
            return free.copy(), (i, j)
        if self.start.heading == 1:
            return np.ascontiguousarray(free[::-1].T), (j, nx - 1 - i)
        if self.start.heading == 2:
            return np.ascontiguousarray(free[::-1, ::-1]), (nx - 1 - i, ny - 1 - j)
        return np.ascontiguousarray(free[:, ::-1].T), (ny - 1 - j, i)
