"""Options of learners that no type checks: configurations may hold anything."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ucon.core.errors import ConfigError, brief
from ucon.task.episode import Episode


def check(wanted: str, holds: Callable[[Any], bool], kinds: Sequence[type] = (int, float), **values: object) -> None:
    """Refuse options that are not ``wanted``; configurations are not typed, so a value may be anything."""
    for name, value in values.items():
        if type(value) not in kinds or not holds(value):
            raise ConfigError(f"learner.{name}={brief(value)}: must be {wanted}")


def text_weights(source: Any, levels: Sequence[str]) -> str:
    """Which weights embed and rank the habits of a :class:`ucon.envs.knowledge.HabitSource` at these levels."""
    return " ".join(sorted({name for level in levels for name in source.weights(level)}))


def check_parts(episodes: Sequence[Episode], chosen_by: Sequence[Episode], parts: Mapping[str, str]) -> None:
    """Refuse to learn from what is not of the ``train`` part, and to choose by what is of the ``test`` part."""
    for episode in chosen_by:
        if odd := next((name for name in episode.entries if parts.get(name) == "test"), None):
            raise ConfigError(
                f"learner.validation.episodes: {episode.id} uses entry {odd} of the test part, by which nothing must "
                "be chosen; give learner.validation.episodes=val"
            )
    for episode in episodes:
        if odd := next((name for name in episode.entries if parts.get(name) != "train"), None):
            raise ConfigError(
                f"learner.episodes: {episode.id} uses entry {odd} of the {parts.get(odd, 'unknown')} part, which must "
                "not be learned from; give learner.episodes=train"
            )
