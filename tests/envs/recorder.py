"""An environment that remembers what was done in it."""

from __future__ import annotations

from typing import Any

import gymnasium as gym

from ucon.envs.search.env import UcONSearchEnv
from ucon.envs.ucon_env import UcONEnv


class Recorder(gym.Wrapper[Any, int, Any, int]):
    """``UcON-v0`` that keeps the last episode's actions, rewards, and whether the target was in view."""

    env: UcONEnv

    def reset(self, **options: Any) -> Any:
        self.actions: list[int] = []
        self.rewards: list[float] = []
        self.collisions = 0
        out = self.env.reset(**options)
        self.saw = self._sees()
        return out

    def step(self, action: int) -> Any:
        out = self.env.step(action)
        self.actions.append(int(action))
        self.rewards.append(float(out[1]))
        self.collisions += int(out[0]["collision"][0])
        self.saw = self.saw or self._sees()
        return out

    def _sees(self) -> bool:
        return bool(self.env.search.counts[self.env.search.target])


def recorded(env: UcONSearchEnv) -> Recorder:
    """Put a recorder around the environment inside an environment of choices."""
    inner = Recorder(env.env)
    env.env = inner  # type: ignore[assignment]
    return inner
