"""What is checked: an environment made by its Gymnasium id, a wrapper around one, or what a callable makes."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np

from ucon.core.errors import ConfigError, UconError, brief, unknown_name
from ucon.envs.image_goal import UcONImageGoalEnv
from ucon.envs.search.env import UcONSearchEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.task.episode import Episode

Env = gym.Env[Any, Any]
OURS: dict[str, Any] = {
    "UcON-v0": UcONEnv,
    "UcONSearch-v0": UcONSearchEnv,
    "UcONImageGoal-v0": UcONImageGoalEnv,
}


class Step(NamedTuple):
    """What a reset or a step answered; a reset pays nothing."""

    obs: Any
    reward: float
    terminated: bool
    truncated: bool
    info: dict[str, Any]

    @property
    def over(self) -> bool:
        """Whether the episode ended with it."""
        return bool(self.terminated or self.truncated)


@dataclass(frozen=True)
class Subject:
    """What is checked, and what it is measured by: the environment of ours that it wraps, by itself."""

    name: str
    make: Callable[..., Env]
    ours: str
    """Gymnasium id of the environment that it wraps."""

    @property
    def chooses(self) -> bool:
        """Whether a step is a choice, not one of the seven actions."""
        return self.ours == "UcONSearch-v0"

    def reference(self, **options: Any) -> Env:
        """The environment of ours with nothing around it."""
        made: Env = OURS[self.ours](**options)
        return made

    def episodes(self) -> tuple[Episode, ...]:
        """Those of the environment inside."""
        return core(self.make()).episodes


def core(env: Env) -> UcONEnv:
    """The seven-action environment inside, which knows the truth."""
    inner: Any = env.unwrapped
    return inner if isinstance(inner, UcONEnv) else inner.env.unwrapped


def reset(env: Env, episode: Any = None, seed: int | None = None) -> Step:
    """Begin an episode: an index, an id, or an episode; None draws one by the seed."""
    obs, info = env.reset(seed=seed, options=None if episode is None else {"episode": episode})
    return Step(obs, 0.0, False, False, info)


def step(env: Env, action: int) -> Step:
    """Take a step."""
    obs, reward, terminated, truncated, info = env.step(action)
    return Step(obs, float(reward), bool(terminated), bool(truncated), info)


def choice(seen: Step, number: int) -> int:
    """A row that may be chosen: another one each time, the same in every run."""
    rows = np.flatnonzero(seen.obs["action_mask"])
    return int(rows[number * 7 % len(rows)])


def subject_of(word: str, around: str = "UcON-v0") -> Subject:
    """What a word of the command line names.

    Args:
        word: a Gymnasium id; or ``MODULE:NAME``, a wrapper class, or a callable that makes an environment by options.
        around: id of the environment that a wrapper class is put around.

    Raises:
        ConfigError: there is no such thing, or it is not made of an environment of ours.
    """
    if word in OURS or ":" not in word:
        make: Callable[..., Env] = _Registered(word)
    else:
        make = _named(word, around)
    try:
        inner = make().unwrapped
    except gym.error.UnregisteredEnv:
        raise ConfigError(unknown_name("environment", word, OURS, remedy="Or give MODULE:NAME.")) from None
    except (gym.error.Error, TypeError, ImportError) as error:
        raise ConfigError(f"{word}: cannot be made ({brief(str(error))}); give a Gymnasium id or MODULE:NAME") from None
    for name, cls in OURS.items():
        if isinstance(inner, cls):
            return Subject(word, make, name)
    raise ConfigError(f"{word}: made of {type(inner).__name__}, expected one of {', '.join(OURS)} inside")


def wrapped(subject: Subject, wrapper: Callable[[Env], Env]) -> Subject:
    """A subject with something around it."""
    return replace(subject, make=_Around(wrapper, subject.make))


@dataclass(frozen=True)
class _Registered:
    id: str

    def __call__(self, **options: Any) -> Env:
        made: Env = gym.make(self.id, disable_env_checker=True, **options)
        return made


@dataclass(frozen=True)
class _Around:
    wrapper: Callable[[Env], Env]
    make: Callable[..., Env]

    def __call__(self, **options: Any) -> Env:
        return self.wrapper(self.make(**options))


def _named(word: str, around: str) -> Callable[..., Env]:
    module, _, name = word.partition(":")
    try:
        found = getattr(importlib.import_module(module), name)
    except UconError:
        raise
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigError(
            f"{word}: not found ({brief(str(error))}); expected MODULE:NAME, importable from here"
        ) from None
    if isinstance(found, type) and issubclass(found, gym.Wrapper):
        return _Around(found, _Registered(around))
    if not callable(found):
        raise ConfigError(f"{word}: {type(found).__name__}, expected a class or a function that makes an environment")
    make: Callable[..., Env] = found
    return make
