"""Checks of learners' options: a configuration may hold a value of any type."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ucon.core.errors import ConfigError, brief
from ucon.task.episode import Episode


def check(wanted: str, holds: Callable[[Any], bool], kinds: Sequence[type] = (int, float), **values: object) -> None:
    """Refuse values of the wrong type or out of range.

    Args:
        wanted: what is expected, in words, for the message.
        holds: whether a value is in range.
        kinds: permitted types, exactly; bool is no int here.
        values: options by name.

    Raises:
        ConfigError: naming the option and what is expected.
    """
    for name, value in values.items():
        if type(value) not in kinds or not holds(value):
            raise ConfigError(f"learner.{name}={brief(value)}: must be {wanted}")


def text_weights(source: Any, levels: Sequence[str]) -> str:
    """Names of the weights that embed and rank habits at these levels, sorted and joined by blanks.

    Args:
        source: a :class:`ucon.envs.knowledge.HabitSource`.
        levels: habit levels.
    """
    return " ".join(sorted({name for level in levels for name in source.weights(level)}))


def check_parts(episodes: Sequence[Episode], chosen_by: Sequence[Episode], parts: Mapping[str, str]) -> None:
    """Refuse training episodes outside the ``train`` part, and validation episodes from the ``test`` part.

    Args:
        episodes: to train on.
        chosen_by: validation episodes, which choose the best checkpoint.
        parts: ``train``, ``val`` or ``test`` by the entry's id.

    Raises:
        ConfigError: naming the first such episode and entry.
    """
    for episode in chosen_by:
        if odd := next((name for name in episode.entries if parts.get(name) == "test"), None):
            raise ConfigError(
                f"learner.validation.episodes: {episode.id} uses entry {odd} of the test part, which must not "
                "choose checkpoints; give learner.validation.episodes=val"
            )
    for episode in episodes:
        if odd := next((name for name in episode.entries if parts.get(name) != "train"), None):
            raise ConfigError(
                f"learner.episodes: {episode.id} uses entry {odd} of the {parts.get(odd, 'unknown')} part, which is "
                "not for training; give learner.episodes=train"
            )
