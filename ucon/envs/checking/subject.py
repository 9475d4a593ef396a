"""The subject of a check: an environment by its Gymnasium id, a wrapper around one, or the result of a callable."""

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
from ucon.task.robot.rig import RobotRig

Env = gym.Env[Any, Any]
#: The environments of UcON, by Gymnasium id.
OURS: dict[str, Any] = {
    "UcON-v0": UcONEnv,
    "UcONSearch-v0": UcONSearchEnv,
    "UcONImageGoal-v0": UcONImageGoalEnv,
}


class Step(NamedTuple):
    """The result of a reset (with reward 0) or of a step."""

    obs: Any
    reward: float
    terminated: bool
    truncated: bool
    info: dict[str, Any]

    @property
    def over(self) -> bool:
        """Whether the episode ended with this step."""
        return bool(self.terminated or self.truncated)


@dataclass(frozen=True)
class Subject:
    """The environment under check, and the environment of UcON inside it, which is the reference.

    Attributes:
        name: as given on the command line.
        make: makes the environment from keyword options.
        ours: Gymnasium id of the environment inside.
    """

    name: str
    make: Callable[..., Env]
    ours: str

    @property
    def chooses(self) -> bool:
        """Whether an action is a choice among views instead of one of the seven actions."""
        return self.ours == "UcONSearch-v0"

    def reference(self, **options: Any) -> Env:
        """Make the environment inside, without wrappers.

        Args:
            **options: options of the environment.
        """
        inner = core(self.make())
        rig = {} if inner.rig is None else {"task": inner.rules.name, "rig": inner.rig}
        made: Env = OURS[self.ours](**rig, **options)
        return made

    def episodes(self) -> tuple[Episode, ...]:
        """The episodes of the environment inside."""
        return core(self.make()).episodes


def core(env: Env) -> UcONEnv:
    """The seven-action environment inside an environment; it knows the privileged facts."""
    inner: Any = env.unwrapped
    return inner if isinstance(inner, UcONEnv) else inner.env.unwrapped


def reset(env: Env, episode: Any = None, seed: int | None = None) -> Step:
    """Reset an environment.

    Args:
        env: the environment.
        episode: an index, an id, or an episode; None draws one from the seed.
        seed: of the reset.
    """
    obs, info = env.reset(seed=seed, options=None if episode is None else {"episode": episode})
    return Step(obs, 0.0, False, False, info)


def step(env: Env, action: int) -> Step:
    """Take a step; converts the reward to float and the ends to bool."""
    obs, reward, terminated, truncated, info = env.step(action)
    return Step(obs, float(reward), bool(terminated), bool(truncated), info)


def choice(seen: Step, number: int) -> int:
    """A row that may be chosen; varies with the number, but is the same in every run.

    Args:
        seen: the last result; its ``action_mask`` is read.
        number: number of the choice in the episode.
    """
    rows = np.flatnonzero(seen.obs["action_mask"])
    return int(rows[number * 7 % len(rows)])


def subject_of(word: str, around: str = "UcON-v0") -> Subject:
    """The subject that a word of the command line names.

    Args:
        word: a Gymnasium id; or ``MODULE:NAME`` of a wrapper class or of a callable that makes an environment from
            options.
        around: id of the environment that a wrapper class is put around.

    Raises:
        ConfigError: there is no such thing, or no environment of UcON is inside it.
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
            _require_exact(word, core(inner).rig)
            return Subject(word, make, name)
    raise ConfigError(f"{word}: made of {type(inner).__name__}, expected one of {', '.join(OURS)} inside")


def _require_exact(word: str, rig: RobotRig | None) -> None:
    """Refuse a robot whose moves err, since the checks execute stored solutions without looking."""
    if rig is not None and (rig.motion_noise or rig.odometry != "exact"):
        raise ConfigError(f"{word}: a robot that moves with errors cannot be checked; give it rig=RobotRig.exact()")


def wrapped(subject: Subject, wrapper: Callable[[Env], Env]) -> Subject:
    """The subject with a further wrapper around it."""
    return replace(subject, make=_Around(wrapper, subject.make))


@dataclass(frozen=True)
class _Registered:
    """Makes an environment from its Gymnasium id."""

    id: str

    def __call__(self, **options: Any) -> Env:
        made: Env = gym.make(self.id, disable_env_checker=True, **options)
        return made


@dataclass(frozen=True)
class _Around:
    """Makes an environment and puts a wrapper around it."""

    wrapper: Callable[[Env], Env]
    make: Callable[..., Env]

    def __call__(self, **options: Any) -> Env:
        return self.wrapper(self.make(**options))


def _named(word: str, around: str) -> Callable[..., Env]:
    """The callable that ``MODULE:NAME`` stands for."""
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
