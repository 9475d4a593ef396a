"""The observation space of ``UcON-v0``."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.sim.render import SKY_DEPTH_M
from ucon.task.actions import Action

MOST_HABITS = 1 << 20
"""Largest ``max_habits``."""
MAX_POSE = 1000.0
"""Bound of the pose's entries."""


def observation_space(image_px: tuple[int, int] | None, dimension: int, max_habits: int, max_steps: int) -> spaces.Dict:
    """The observation space of :class:`ucon.envs.ucon_env.UcONEnv`, which explains its entries.

    Args:
        image_px: height and width of the images; None: no images.
        dimension: length of a text embedding.
        max_habits: rows of habits, padded.
        max_steps: steps of an episode.

    Raises:
        ConfigError: ``max_habits`` is out of range.
    """
    if type(max_habits) is not int or not 1 <= max_habits <= MOST_HABITS:
        raise ConfigError(f"max_habits={brief(max_habits)}: expected a whole number from 1 to {MOST_HABITS}")
    entries: dict[str, spaces.Space[Any]] = {}
    if image_px is not None:
        height, width = image_px
        entries["rgb"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
        entries["depth"] = spaces.Box(0.0, SKY_DEPTH_M, (height, width), np.float32)
    entries |= {
        "pose": spaces.Box(-MAX_POSE, MAX_POSE, (4,), np.float32),
        "target": spaces.Box(-1.0, 1.0, (dimension,), np.float32),
        "habits": spaces.Box(-1, np.iinfo(np.int32).max, (max_habits,), np.int32),
        "habits_mask": spaces.MultiBinary(max_habits),
        "last_action": spaces.MultiBinary(len(Action)),
        "collision": spaces.MultiBinary(1),
        "step": spaces.Box(0, max_steps, (1,), np.int64),
    }
    return spaces.Dict(entries)


def padded(rows: NDArray[np.int32], max_habits: int, where: str) -> tuple[NDArray[np.int32], NDArray[np.int8]]:
    """``habits`` and ``habits_mask`` of an observation.

    Args:
        rows: (n,) rows of the habits given.
        max_habits: length of both.
        where: names the episode in the error.

    Returns:
        (max_habits,) int32, -1 past n, and (max_habits,) int8.

    Raises:
        ConfigError: there are more rows than ``max_habits``.
    """
    if len(rows) > max_habits:
        n = len(rows)
        raise ConfigError(
            f"{where}: {n} habits, expected at most {max_habits}; give env.max_habits={n} or more, "
            "habit_level=retrieval, or fewer habits"
        )
    habits = np.full(max_habits, -1, np.int32)
    habits[: len(rows)] = rows
    return habits, (habits >= 0).astype(np.int8)
