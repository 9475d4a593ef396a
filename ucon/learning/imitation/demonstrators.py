"""What a policy over the seven actions imitates: stored shortest solutions, or the searches of another agent.

A shortest solution walks straight to a target whose location the policy cannot know. A searching agent acts on habits
read and frames seen, which the policy has too, so its decisions can all be learned: where to look next, what to open,
when to stop.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from functools import cached_property
from typing import Any, Final, Protocol

from ucon.core.errors import ConfigError
from ucon.core.files import sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.learning.imitation.trajectories import Trajectory, demonstration
from ucon.learning.run.kept_batches import code_hash
from ucon.learning.run.option_checks import text_weights
from ucon.retrieval.levels import LEVELS
from ucon.task.agent import Agent
from ucon.task.episode import Episode

#: Code that decides what an agent does.
_CODE: Final = (
    "core", "envs", "habits", "language", "objects", "perception", "readers", "retrieval", "scenes", "search", "sim",
    "task", "../models",
)  # fmt: skip


class Demonstrator(Protocol):
    """Gives, for an episode and a habit level, the trajectory that a policy is to imitate."""

    batch: int
    """Episodes in one step's batch on a CPU, where ``learner.batch=auto``."""

    @property
    def title(self) -> str:
        """The demonstrator in words, for the model card."""
        ...

    def fingerprint(self) -> str:
        """Hash or name of everything besides the episodes that its trajectories depend on; "" for nothing."""
        ...

    def cache_key(self) -> str:
        """Hash of all that its trajectories depend on, code included; "" if they are not to be kept in the cache."""
        ...

    def close(self) -> None:
        """Release what it holds."""
        ...

    def __call__(self, episode: Episode, level: str) -> Trajectory:
        """Actions and labels for an episode.

        Args:
            episode: the episode to solve.
            level: habit level at which the policy will see it.
        """
        ...


def check_agent(agent: Agent, option: str) -> None:
    """Refuse an object that is no agent, or an agent that cannot play.

    Args:
        agent: of a configuration.
        option: its name, for the error.

    Raises:
        ConfigError: it has no ``reset`` and ``act``, or its weights are missing.
    """
    if not (hasattr(agent, "reset") and hasattr(agent, "act")):
        raise ConfigError(f"{option}: {type(agent).__name__} is no agent; see configs/agent/")
    if hasattr(agent, "check"):
        agent.check()


def agent_fingerprint(agent: Agent) -> str:
    """Name of an agent and the hash of its weights, if it has any."""
    return f"{agent.name} {fingerprint_of(agent) or ''}"


class SolutionDemonstrator:
    """Demonstrates each episode's stored shortest solution, which opens the containers that have to be opened.

    The solution uses the true place of the target; it reads no habits and is the same at every habit level.
    """

    title = "an expert that knows where the target is"
    batch = 16

    def fingerprint(self) -> str:
        """Empty: the solutions are part of the episodes, which have hashes of their own."""
        return ""

    def cache_key(self) -> str:
        """Empty: the solutions are stored with the episodes."""
        return ""

    def close(self) -> None:
        """Nothing to release."""

    def __call__(self, episode: Episode, level: str) -> Trajectory:
        """The stored solution as actions and as labels; ``level`` only says what the policy is given."""
        return demonstration(episode, level)


class AgentDemonstrator:
    """Demonstrates what a searching agent does in an episode, if it succeeds there; else the stored shortest solution.

    Args:
        agent: plays one episode at a time.
        env: makes an environment of ``UcON-v0`` with everything the agent reads; called when the first episode comes.

    Raises:
        ConfigError: ``agent`` has no ``reset`` and ``act``.
    """

    batch = 8  # half of the solutions' batch: searches take more steps

    def __init__(self, agent: Agent, env: Callable[[], Any]) -> None:
        check_agent(agent, "learner.demonstrator.agent")
        self._agent, self._make_env = agent, env
        self.title = f"what the agent {agent.name} does"

    def fingerprint(self) -> str:
        """Name of the agent and the hash of its weights, if it has any."""
        return agent_fingerprint(self._agent)

    def cache_key(self) -> str:
        """Hash of code, agent, weights, habits and detector; "" for an agent that cannot be pickled."""
        try:
            agent = pickle.dumps(self._agent)
        except (pickle.PicklingError, AttributeError, TypeError):
            return ""
        env = self._env.unwrapped
        errors = getattr(env.detector, "errors", None)
        parts = [code_hash(*_CODE), sha256_bytes(agent), self.fingerprint(), env.source.dataset.sha256]
        parts += [str(getattr(env.detector, "name", "")), "" if errors is None else errors.fingerprint()]
        parts.append(text_weights(env.source, LEVELS))
        return sha256_bytes("\n".join(parts).encode())

    @cached_property
    def _env(self) -> Any:
        return self._make_env()

    def close(self) -> None:
        """Close the environment; the next call makes a new one."""
        if "_env" in self.__dict__:
            self.__dict__.pop("_env").close()

    def __getstate__(self) -> dict[str, Any]:
        """State for worker processes, which make an environment of their own."""
        return {name: value for name, value in self.__dict__.items() if name != "_env"}

    def __call__(self, episode: Episode, level: str) -> Trajectory:
        """Play the episode with the agent at a habit level.

        Returns:
            The agent's actions, which are their own labels; the stored solution where the agent failed.
        """
        observation, info = self._env.reset(seed=0, options={"episode": episode, "habit_level": level})
        self._agent.reset([info])
        actions, over = "", False
        while not over:
            action = int(self._agent.act([observation], [info])[0])
            observation, _, terminated, truncated, info = self._env.step(action)
            actions, over = actions + str(action), terminated or truncated
        found = bool(info["episode_metrics"]["success"])
        return Trajectory(episode, level, actions, actions) if found else demonstration(episode, level)
