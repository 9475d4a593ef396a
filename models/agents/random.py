"""``random``: random actions, the lower bound of every comparison."""

from __future__ import annotations

import numpy as np

from models.agents.base import Controller, ControllerAgent
from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.task.actions import Action
from ucon.task.agent import Info, Observation


class _Dice:
    def __init__(self, generator: np.random.Generator, done: float) -> None:
        rest = len(Action) - 1
        self._generator = generator
        self._chances = np.array([(1.0 - done) / rest] * rest + [done])

    def act(self, observation: Observation, info: Info) -> int:
        return int(self._generator.choice(len(Action), p=self._chances))


class RandomAgent(ControllerAgent):
    """Draws among the seven actions; an episode's draws depend only on the seed and the episode.

    Args:
        seed: of the draws.
        done_probability: of Done; the other six share the rest equally.

    Raises:
        ConfigError: a probability outside [0, 1].
    """

    name = "random"
    uses_habits = False

    def __init__(self, seed: int = 0, done_probability: float = 0.01) -> None:
        super().__init__()
        if not 0 <= done_probability <= 1:
            raise ConfigError(f"agent.done_probability={done_probability}: expected a probability from 0 to 1")
        self._seed, self._done = seed, done_probability

    def start(self, info: Info) -> Controller:
        """A controller with the random stream of the episode."""
        return _Dice(stream(self._seed, "random", str(info.get("episode", ""))), self._done)
