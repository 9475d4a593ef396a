"""Who shows a policy over the seven actions what to do: the stored shortest solutions, or an agent that searches.

A shortest solution goes straight to what nobody can know. What a searching agent does follows from what it has read
and seen, as much as the policy has, so all of it can be learned: where to look next, what to open, when to give up.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Protocol

from ucon.core.errors import ConfigError
from ucon.core.fingerprint import fingerprint_of
from ucon.learning.imitation.trajectories import Trajectory, demonstration
from ucon.task.agent import Agent
from ucon.task.episode import Episode


class Demonstrator(Protocol):
    """Shows how an episode is played."""

    batch: int
    """Episodes that one step learns from on a CPU, unless another number is given."""

    @property
    def title(self) -> str:
        """Who shows it."""
        ...

    def fingerprint(self) -> str:
        """What decides what it shows, beside the episodes; "" for nothing."""
        ...

    def __call__(self, episode: Episode, level: str) -> Trajectory:
        """What is to be done in an episode at a habit level."""
        ...


class Solutions:
    """The stored shortest solutions."""

    title = "an expert that knows where the target is"
    batch = 16

    def fingerprint(self) -> str:
        """See :class:`Demonstrator`."""
        return ""

    def __call__(self, episode: Episode, level: str) -> Trajectory:
        """See :class:`Demonstrator`."""
        return demonstration(episode, level)


class Searches:
    """What an agent does that searches, where it finds the target; the stored solution where it does not.

    Args:
        agent: plays one episode after the other.
        env: makes an environment of ``UcON-v0``, with what the agent reads; called when the first episode comes.

    Raises:
        ConfigError: ``agent`` is none.
    """

    batch = 8  # searches are long

    def __init__(self, agent: Agent, env: Callable[[], Any]) -> None:
        if not (hasattr(agent, "reset") and hasattr(agent, "act")):
            raise ConfigError(f"learner.demonstrator.agent: {type(agent).__name__} is no agent; see configs/agent/")
        if hasattr(agent, "check"):
            agent.check()
        self._agent, self._make_env = agent, env
        self.title = f"what the agent {agent.name} does"

    def fingerprint(self) -> str:
        """See :class:`Demonstrator`."""
        return f"{self._agent.name} {fingerprint_of(self._agent) or ''}"

    @cached_property
    def _env(self) -> Any:
        return self._make_env()

    def __call__(self, episode: Episode, level: str) -> Trajectory:
        """See :class:`Demonstrator`."""
        observation, info = self._env.reset(seed=0, options={"episode": episode, "habit_level": level})
        self._agent.reset([info])
        actions, over = "", False
        while not over:
            action = int(self._agent.act([observation], [info])[0])
            observation, _, terminated, truncated, info = self._env.step(action)
            actions, over = actions + str(action), terminated or truncated
        found = bool(info["episode_metrics"]["success"])
        return Trajectory(episode, level, actions, actions) if found else demonstration(episode, level)
