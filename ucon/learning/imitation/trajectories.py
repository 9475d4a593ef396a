"""What policies imitate: trajectories as plain data, and what a policy sees along them, made by playing them again.

The environment gives the same frames for the same actions, so a trajectory is an episode, a habit level and two strings
of digits: a thousand of them are a few hundred kilobytes, in a checkpoint too, whatever a policy makes of the frames.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.retrieval.levels import LEVELS
from ucon.task.actions import Action
from ucon.task.episode import Episode

if TYPE_CHECKING:
    import gymnasium as gym

    from ucon.learning.policies.action_policy import ActionPolicy

#: In place of a label: the expert had no answer.
NO_LABEL: Final = "."
#: The same as a class of the cross-entropy.
IGNORED: Final = -1


@dataclass(frozen=True)
class Trajectory:
    """What was done in an episode, and what an expert would have done instead at every step."""

    episode: Episode
    level: str
    """Habit level at which the policy is told about it."""
    actions: str
    """The actions taken, as digits."""
    labels: str
    """The expert's, as digits; :data:`NO_LABEL` where it had none. As long as ``actions``."""

    @property
    def key(self) -> tuple[str, str, str]:
        """What decides the frames."""
        return self.episode.id, self.level, self.actions

    @property
    def classes(self) -> NDArray[np.int64]:
        """(T,) the labels as numbers of actions, :data:`IGNORED` for none."""
        return np.array([IGNORED if digit == NO_LABEL else int(digit) for digit in self.labels], np.int64)

    @property
    def changes(self) -> NDArray[np.bool_]:
        """(T,) where the label is another action than the one before it, which is where something is decided."""
        return np.array([a != b for a, b in zip(self.labels, NO_LABEL + self.actions, strict=False)])

    @property
    def n_labels(self) -> int:
        """How many of its steps are labelled."""
        return len(self.labels) - self.labels.count(NO_LABEL)

    def to_json(self) -> list[str]:
        """Plain values; the episode by its id."""
        return [self.episode.id, self.level, self.actions, self.labels]


def demonstration(episode: Episode, level: str) -> Trajectory:
    """The stored shortest solution, which opens containers, as a trajectory."""
    return Trajectory(episode, level, episode.solution, episode.solution)


def trajectories_from_json(rows: Any, episodes: Mapping[str, Episode]) -> list[Trajectory]:
    """What :meth:`Trajectory.to_json` wrote; ``episodes`` by id.

    Raises:
        DataError: a row that is none, or of an episode that is not among them.
    """
    if not isinstance(rows, list) or not all(_is_trajectory(row, episodes) for row in rows):
        raise DataError("state with a trajectory of other episodes; resume with the run's own configuration")
    return [Trajectory(episodes[name], level, actions, labels) for name, level, actions, labels in rows]


def _is_trajectory(row: Any, episodes: Mapping[str, Episode]) -> bool:
    if not (isinstance(row, list) and len(row) == 4 and all(isinstance(text, str) for text in row)):
        return False
    name, level, actions, labels = row
    digits = {str(int(action)) for action in Action}
    right = digits.issuperset(actions) and digits.issuperset(labels.replace(NO_LABEL, ""))
    return name in episodes and level in LEVELS and right and len(actions) == len(labels) > 0


@dataclass(frozen=True)
class Replay:
    """What a policy sees along a trajectory of T steps."""

    context: Mapping[str, NDArray[Any]]
    """Arrays (...) of the episode."""
    frames: Mapping[str, NDArray[Any]]
    """Arrays (T, ...), before each action."""
    rewards: NDArray[np.float32]
    """(T,) of each action."""

    def __len__(self) -> int:
        return len(self.rewards)


class Replayer:
    """Plays trajectories again and has the policy turn what is seen into arrays. One process, one environment.

    Args:
        policy: its ``context`` and ``frame`` are asked; its weights do not matter.
        make_env: makes an environment of ``UcON-v0``; called when the first trajectory comes.
    """

    def __init__(self, policy: ActionPolicy, make_env: Callable[[], gym.Env[Any, Any]]) -> None:
        self._policy, self._make_env = policy, make_env
        self._env: gym.Env[Any, Any] | None = None

    def __call__(self, trajectory: Trajectory) -> Replay:
        """Replay one trajectory.

        Raises:
            DataError: its actions go on after the episode's end.
        """
        if self._env is None:
            self._env = self._make_env()
        options = {"episode": trajectory.episode, "habit_level": trajectory.level}
        observation, info = self._env.reset(seed=0, options=options)
        context = dict(self._policy.context(info))
        frames, rewards, ended = [], [], False
        for digit in trajectory.actions:
            if ended:
                raise DataError(f"episode {trajectory.episode.id}: actions after its end; it was made by other rules")
            frames.append(self._policy.frame(observation, info))
            observation, reward, terminated, truncated, info = self._env.step(int(digit))
            rewards.append(float(reward))
            ended = terminated or truncated
        stacked = {name: np.stack([np.asarray(frame[name]) for frame in frames]) for name in frames[0]}
        return Replay(context, stacked, np.array(rewards, np.float32))

    def close(self) -> None:
        """Close the environment."""
        if self._env is not None:
            self._env.close()
            self._env = None


def returns(rewards: NDArray[np.float32], discount: float) -> NDArray[np.float32]:
    """(T,) discounted sum of the rewards from each step on."""
    found = np.zeros(len(rewards), np.float32)
    later = 0.0
    for step in range(len(rewards) - 1, -1, -1):
        later = float(rewards[step]) + discount * later
        found[step] = later
    return found
