"""Makes what a policy sees along a trajectory, by playing its actions again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from ucon.core.errors import DataError
from ucon.learning.imitation.experts import Corrector
from ucon.learning.imitation.trajectories import Replay, Trajectory
from ucon.learning.imitation.view_labels import Label
from ucon.learning.policies.action_policy import Arrays
from ucon.learning.policies.playing import Seen, led

if TYPE_CHECKING:
    import gymnasium as gym

    from ucon.learning.policies.action_policy import ActionPolicy

#: Slot of the expert in replays; players have those from 0 up.
_SLOT: Final = -1


class Replayer:
    """Plays trajectories again and has the policy turn observations into arrays; one process, one environment.

    Args:
        policy: its ``context`` and ``frame`` are called; its weights do not matter.
        make_env: makes an environment of ``UcON-v0``; called when the first trajectory comes.
        expert: labels views along the trajectory again; None: no views are labelled.
    """

    def __init__(
        self, policy: ActionPolicy, make_env: Callable[[], gym.Env[Any, Any]], expert: Corrector | None = None
    ) -> None:
        self._policy, self._make_env, self._expert = policy, make_env, expert
        self._env: gym.Env[Any, Any] | None = None

    def __call__(self, trajectory: Trajectory) -> Replay:
        """Replay one trajectory of T steps.

        Returns:
            Context arrays (...), frame arrays (T, ...) and rewards (T,) float32.

        Raises:
            DataError: its actions continue after the episode's end.
        """
        if self._env is None:
            self._env = self._make_env()
        options = {"episode": trajectory.episode, "habit_level": trajectory.level}
        observation, info = self._env.reset(seed=0, options=options)
        context = dict(self._policy.context(info))
        frames, rewards, views, ended = list[Arrays](), list[float](), list[Label](), False
        if self._expert is not None:
            self._expert.begin(_SLOT, trajectory.episode, self._env, info)
        seen = led(self._env, trajectory.led, Seen(observation, info))
        for digit in trajectory.actions:
            if ended:
                raise DataError(
                    f"episode {trajectory.episode.id}: actions after its end; it was made under other rules"
                )
            frames.append(self._policy.frame(*seen))
            if self._expert is not None:
                self._expert.label(_SLOT, *seen)
                views.append(self._expert.views(_SLOT))
            observation, reward, terminated, truncated, info = self._env.step(int(digit))
            seen = Seen(observation, info)
            rewards.append(float(reward))
            ended = terminated or truncated
        stacked = {name: np.stack([np.asarray(frame[name]) for frame in frames]) for name in frames[0]}
        replay = Replay(context, stacked, np.array(rewards, np.float32))
        return with_views(replay, None if self._expert is None else views)

    def close(self) -> None:
        """Close the environment; the next call makes a new one."""
        if self._env is not None:
            self._env.close()
            self._env = None


def learns_views(policy: Any) -> bool:
    """Whether a policy learns from an expert's scores of views."""
    return bool(policy.learns_views)


def with_views(replay: Replay, views: Sequence[Label] | None) -> Replay:
    """A replay with the labels of views among its frames, as ``views`` (T, N_VIEWS, 4); None: as it is."""
    return replay if views is None else replace(replay, frames={**replay.frames, "views": np.stack(views)})
