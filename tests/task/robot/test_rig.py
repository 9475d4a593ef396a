"""Impossible rigs are refused in one line."""

from __future__ import annotations

from typing import Any

import pytest

from ucon.core.errors import ConfigError
from ucon.task.robot.rig import RobotRig

WRONG: dict[str, Any] = {
    "camera_m": (-0.1, 0.0, 5.0, float("nan"), "high", True),
    "radius_m": (0.0, -1.0, 0.6, float("inf")),
    "motion_noise": (-1.0, float("nan"), 1e9),
    "odometry": ("true", True, "gps"),
    "depth": ("lidar", False),
    "seed": (-1, 0.5, True),
}


@pytest.mark.parametrize(("name", "value"), [(name, value) for name, values in WRONG.items() for value in values])
def test_impossible_rigs_are_refused(name: str, value: Any) -> None:
    with pytest.raises(ConfigError, match=f"rig.{name}=.*expected") as error:
        RobotRig(**{name: value})
    assert "\n" not in str(error.value)


def test_an_exact_rig_has_no_errors() -> None:
    rig = RobotRig.exact(camera_m=1.0)
    assert (rig.motion_noise, rig.odometry, rig.depth, rig.camera_m) == (0.0, "exact", "exact", 1.0)
    assert rig.top_m > rig.camera_m
