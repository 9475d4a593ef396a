"""An agent and its environments, made once in a process and used for all that it plays there."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import gymnasium as gym

from ucon.task.agent import Agent

Env = gym.Env[Any, Any]


class Stage:
    """The agent of a process, and environments that are made when they are first needed.

    Args:
        agent: makes the agent.
        env: makes an environment.

    Attributes:
        agent: reset before every episode, so that what it plays does not depend on what it played.
    """

    def __init__(self, agent: Callable[[], Agent], env: Callable[[], Env]) -> None:
        self.agent, self._make_env = agent(), env
        self._envs: list[Env] = []
        one_thread()

    def envs(self, count: int) -> list[Env]:
        """The first ``count`` environments."""
        while len(self._envs) < count:
            self._envs.append(self._make_env())
        return self._envs[:count]

    def close(self) -> None:
        """Close the environments."""
        while self._envs:
            self._envs.pop().close()


def one_thread() -> None:
    """Limit torch to one thread: workers give the parallelism, and sums must not depend on the number of threads."""
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(1)
