"""Trajectories as plain data, and the frames along them, made by playing their actions again.

The environment gives the same frames for the same actions, so a trajectory is an episode, a habit level and two strings
of digits: a thousand of them take a few hundred kilobytes, whatever arrays a policy makes of the frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.retrieval.levels import LEVELS
from ucon.task.actions import Action
from ucon.task.episode import Episode

#: Stands for a label in the string of digits where the expert had no action.
NO_LABEL: Final = "."
#: Class index of such a step, which the cross-entropy leaves out.
IGNORED: Final = -1


@dataclass(frozen=True)
class Trajectory:
    """The actions taken in an episode, and an expert's label for each step."""

    episode: Episode
    level: str
    """Habit level at which the policy sees the episode."""
    actions: str
    """The T actions taken, one digit each (see :class:`ucon.task.actions.Action`)."""
    labels: str
    """The T labels, one digit each; :data:`NO_LABEL` where the expert had none."""
    led: str = field(default="", kw_only=True)
    """Actions taken before those of ``actions``, one digit each."""

    @property
    def key(self) -> tuple[str, str, str, str]:
        """Episode id, habit level and all actions: equal keys have equal frames."""
        return self.episode.id, self.level, self.led, self.actions

    @property
    def classes(self) -> NDArray[np.int64]:
        """(T,) int64, action index of each label; :data:`IGNORED` where there is none."""
        return np.array([IGNORED if digit == NO_LABEL else int(digit) for digit in self.labels], np.int64)

    @property
    def changes(self) -> NDArray[np.bool_]:
        """(T,) bool, True where the label differs from the action taken one step earlier; True at the first step."""
        return np.array([a != b for a, b in zip(self.labels, NO_LABEL + self.actions, strict=False)])

    @property
    def n_labels(self) -> int:
        """Number of steps that have a label."""
        return len(self.labels) - self.labels.count(NO_LABEL)

    def to_json(self) -> list[str]:
        """Episode id, level, actions, labels, and ``led`` if there is any: plain values that JSON can hold."""
        return [self.episode.id, self.level, self.actions, self.labels, *([self.led] if self.led else [])]


def demonstration(episode: Episode, level: str) -> Trajectory:
    """The episode's stored shortest solution as a trajectory whose labels are its actions.

    Args:
        episode: has the solution, which opens containers where needed.
        level: habit level at which the policy sees the episode.
    """
    return Trajectory(episode, level, episode.solution, episode.solution)


def trajectories_from_json(rows: Any, episodes: Mapping[str, Episode]) -> list[Trajectory]:
    """Read what :meth:`Trajectory.to_json` wrote.

    Args:
        rows: plain values, one row per trajectory; not trusted.
        episodes: known episodes by id.

    Raises:
        DataError: a row of another form, or of an unknown episode.
    """
    if not isinstance(rows, list) or not all(_is_trajectory(row, episodes) for row in rows):
        raise DataError("state with a trajectory of other episodes; resume with the run's own configuration")
    return [
        Trajectory(episodes[name], level, actions, labels, led="".join(led))
        for name, level, actions, labels, *led in rows
    ]


def _is_trajectory(row: Any, episodes: Mapping[str, Episode]) -> bool:
    if not (isinstance(row, list) and len(row) in (4, 5) and all(isinstance(text, str) for text in row)):
        return False
    name, level, actions, labels, *led = row
    digits = {str(int(action)) for action in Action}
    right = all(digits.issuperset(did) for did in (actions, labels.replace(NO_LABEL, ""), *led))
    return name in episodes and level in LEVELS and right and len(actions) == len(labels) > 0


@dataclass(frozen=True)
class Replay:
    """The arrays that a policy sees along a trajectory of T steps."""

    context: Mapping[str, NDArray[Any]]
    """Arrays (...) that stay the same for the whole episode."""
    frames: Mapping[str, NDArray[Any]]
    """Arrays (T, ...), each row seen before the action of that step."""
    rewards: NDArray[np.float32]
    """(T,) reward of each action."""

    def __len__(self) -> int:
        return len(self.rewards)


def returns(rewards: NDArray[np.float32], discount: float) -> NDArray[np.float32]:
    """Discounted sum of the rewards from each step on.

    Args:
        rewards: (T,) float32.
        discount: factor per step, from 0 to 1.

    Returns:
        (T,) float32.
    """
    found = np.zeros(len(rewards), np.float32)
    later = 0.0
    for step in range(len(rewards) - 1, -1, -1):
        later = float(rewards[step]) + discount * later
        found[step] = later
    return found
