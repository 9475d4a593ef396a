"""The agent's frame rotates the grid and poses in the same way."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.envs.frame import StartFrame
from ucon.task.actions import AHEAD
from ucon.task.episode import Start
from ucon.task.search import Pose


@pytest.mark.parametrize("heading", range(4))
def test_grid_and_pose_agree(heading: int) -> None:
    rng = np.random.default_rng(heading)
    free = rng.random((7, 5)) < 0.6
    start = Start(3, 2, heading)
    frame = StartFrame(start)
    grid, (i0, j0) = frame.grid(free)
    for i in range(7):
        for j in range(5):
            x, y, yaw, _ = frame.pose(Pose(i, j, heading))
            assert yaw == 0.0
            assert grid[i0 + round(x / 0.25), j0 + round(y / 0.25)] == free[i, j]


@pytest.mark.parametrize("heading", range(4))
def test_moving_ahead_is_along_x(heading: int) -> None:
    dx, dy = AHEAD[heading]
    pose = StartFrame(Start(5, 5, heading)).pose(Pose(5 + dx, 5 + dy, (heading + 1) % 4, 0, -30))
    assert pose == pytest.approx([0.25, 0.0, np.pi / 2, -np.pi / 6])
