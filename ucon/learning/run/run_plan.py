"""How long a run of training is, how often it validates and saves, and by what it was extended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final

from ucon.core.errors import ConfigError, brief, unknown_name

_NUMBERS: Final = ("steps", "validate_every", "save_every", "keep")
#: Names of checkpoints have eight digits.
MOST_STEPS: Final = 99_999_999


@dataclass(frozen=True)
class Extension:
    """More steps than were planned: after ``at`` steps were done it was decided to take ``steps`` in all."""

    at: int
    steps: int

    def to_json(self) -> dict[str, int]:
        """As configurations, checkpoints and summaries hold it."""
        return {"at": self.at, "steps": self.steps}


@dataclass(frozen=True)
class Plan:
    """How long, and how often what.

    Args:
        steps: planned at the start.
        validate_every, save_every: steps between two of these.
        keep: newest checkpoints that stay, beside the best.
        extended: by what the run was extended since, in order; ``resume=RUN training.steps=MORE`` writes it.

    Raises:
        ConfigError: a number out of range, or extensions that do not follow from each other.
    """

    steps: int
    validate_every: int = 50
    save_every: int = 50
    keep: int = 2
    extended: tuple[Extension, ...] = ()

    def __post_init__(self) -> None:
        for name in _NUMBERS:
            value = getattr(self, name)
            if type(value) is not int or not 1 <= value <= MOST_STEPS:
                raise ConfigError(f"training.{name}={brief(value)}: expected a whole number from 1 to {MOST_STEPS}")
        at, steps = -1, self.steps
        for one in self.extended:
            if not at < one.at <= steps < one.steps <= MOST_STEPS:
                raise ConfigError(
                    f"training.extended: from {brief(one.at)} to {brief(one.steps)} steps does not follow from "
                    f"{steps}; restore it, or start the run anew"
                )
            at, steps = one.at, one.steps

    @classmethod
    def of(cls, options: Any) -> Plan:
        """The plan that a configuration describes.

        Raises:
            ConfigError: no options at all, an unknown or a missing one, or a number out of range.
        """
        names = [field.name for field in fields(cls)]
        if not isinstance(options, Mapping):
            raise ConfigError(f"training={brief(options)}: expected the options {', '.join(_NUMBERS)}")
        if odd := next((name for name in options if name not in names), None):
            raise ConfigError(unknown_name("option", f"training.{odd}", [f"training.{name}" for name in _NUMBERS]))
        if "steps" not in options:
            raise ConfigError("training.steps has no value; give training.steps=...")
        given = dict(options)
        return cls(**{**given, "extended": extensions(given.get("extended", ()))})

    @property
    def length(self) -> int:
        """Steps in all, with those of extensions."""
        return self.extended[-1].steps if self.extended else self.steps

    def length_at(self, step: int) -> int:
        """Steps that were planned in all when step number ``step``, from 0, is taken: schedules are of that length."""
        return next((one.steps for one in reversed(self.extended) if one.at <= step), self.steps)

    def followed(self, step: int) -> tuple[Extension, ...]:
        """The extensions that a state after ``step`` steps depends on."""
        return tuple(one for one in self.extended if one.at < step)

    def validates(self, step: int) -> bool:
        """Whether the state after ``step`` steps is validated: at intervals, and where the run ended or had ended."""
        ended = any(one.at == step == self.length_at(step - 1) for one in self.extended)
        return step % self.validate_every == 0 or step == self.length or ended

    def saves(self, step: int) -> bool:
        """Whether the state after ``step`` steps is saved, unless the run is stopped there: then it is too."""
        return step % self.save_every == 0 or self.validates(step)

    def extend(self, step: int, steps: int) -> Plan:
        """This plan with ``steps`` in all, decided when ``step`` are done; itself where it has as many.

        Extensions that were decided later are forgotten: the run went back to before them.

        Raises:
            ConfigError: so many are done, or more are planned.
        """
        before = self.followed(step)
        planned = before[-1].steps if before else self.steps
        if steps <= step:
            raise ConfigError(f"training.steps={steps}: {step} are done; give more, or leave it out")
        if steps == self.length:
            return self
        if steps <= planned:
            raise ConfigError(f"training.steps={steps}: the run has {planned}; give more, or leave it out")
        return replace(self, extended=(*before, Extension(step, steps)))


def extensions(given: Any) -> tuple[Extension, ...]:
    """Extensions as a configuration or a checkpoint holds them.

    Raises:
        ConfigError: they are none.
    """
    whole = isinstance(given, list | tuple) and all(
        isinstance(one, Mapping) and one.keys() == {"at", "steps"} and all(type(value) is int for value in one.values())
        for one in given
    )
    if not whole:
        raise ConfigError(f"training.extended={brief(given)}: expected a list of numbers at and steps; leave it out")
    return tuple(Extension(**one) for one in given)
