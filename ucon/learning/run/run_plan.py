"""Length of a training run, how often it validates and saves, and its extensions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Final

from ucon.core.errors import ConfigError, brief, unknown_name

_NUMBERS: Final = ("steps", "validate_every", "save_every", "keep")
#: Names of checkpoints have eight digits for the step.
MOST_STEPS: Final = 99_999_999


@dataclass(frozen=True)
class Extension:
    """An extension of a run: after ``at`` steps were done, its length was raised to ``steps`` steps in all."""

    at: int
    steps: int

    def to_json(self) -> dict[str, int]:
        """Plain values ``at`` and ``steps``, as configurations, checkpoints and summaries hold them."""
        return {"at": self.at, "steps": self.steps}


@dataclass(frozen=True)
class Plan:
    """Length of a run and its intervals.

    Args:
        steps: planned at the start.
        validate_every: steps between validations.
        save_every: steps between checkpoints.
        keep: number of newest checkpoints to keep, besides the best.
        extended: later extensions, in order; ``resume=RUN training.steps=MORE`` adds one.

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
                    f"{steps}; restore it, or start a new run"
                )
            at, steps = one.at, one.steps

    @classmethod
    def of(cls, options: Any) -> Plan:
        """The plan of a configuration.

        Args:
            options: the mapping ``training`` of the configuration.

        Raises:
            ConfigError: no mapping, an unknown or a missing option, or a number out of range.
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
        """Number of steps in all, extensions included."""
        return self.extended[-1].steps if self.extended else self.steps

    def length_at(self, step: int) -> int:
        """Length of the run as planned when step number ``step`` (from 0) is taken; schedules have that length."""
        return next((one.steps for one in reversed(self.extended) if one.at <= step), self.steps)

    def followed(self, step: int) -> tuple[Extension, ...]:
        """The extensions that were made before the state after ``step`` steps, on which it depends."""
        return tuple(one for one in self.extended if one.at < step)

    def validates(self, step: int) -> bool:
        """Whether the state after ``step`` steps is validated: at intervals, and at the end as planned then."""
        ended = any(one.at == step == self.length_at(step - 1) for one in self.extended)
        return step % self.validate_every == 0 or step == self.length or ended

    def saves(self, step: int) -> bool:
        """Whether the state after ``step`` steps is saved; a run that is stopped saves its state in any case."""
        return step % self.save_every == 0 or self.validates(step)

    def extend(self, step: int, steps: int) -> Plan:
        """This plan with a length of ``steps``, decided after ``step`` steps; the plan itself where it has that length.

        Extensions made after ``step`` are dropped: the run went back to a checkpoint before them.

        Raises:
            ConfigError: ``steps`` are done already, or more are planned.
        """
        before = self.followed(step)
        planned = before[-1].steps if before else self.steps
        if steps <= step:
            raise ConfigError(f"training.steps={steps}: {step} steps are done; give more, or leave it out")
        if steps == self.length:
            return self
        if steps <= planned:
            raise ConfigError(f"training.steps={steps}: the run already has {planned}; give more, or leave it out")
        return replace(self, extended=(*before, Extension(step, steps)))


def extensions(given: Any) -> tuple[Extension, ...]:
    """Extensions from a configuration or a checkpoint.

    Args:
        given: list of mappings with whole numbers ``at`` and ``steps``; not trusted.

    Raises:
        ConfigError: it has another form.
    """
    whole = isinstance(given, list | tuple) and all(
        isinstance(one, Mapping) and one.keys() == {"at", "steps"} and all(type(value) is int for value in one.values())
        for one in given
    )
    if not whole:
        raise ConfigError(f"training.extended={brief(given)}: expected a list of numbers at and steps; leave it out")
    return tuple(Extension(**one) for one in given)
