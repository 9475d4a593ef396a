"""The trainer's part of a checkpoint, besides the state of the learner."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from ucon.core.errors import ConfigError, DataError
from ucon.learning.run.run_plan import Extension, extensions

#: Figure of :meth:`~ucon.learning.run.protocol.Learner.validate` that chooses the best checkpoint; larger is better.
SCORE: Final = "score"
_LONGEST_NAME: Final = 80


@dataclass(frozen=True)
class TrainerState:
    """Step and validation figures of the best checkpoint so far, and the extensions made before this state."""

    best: dict[str, float] = field(default_factory=dict)
    """Figures by name, with ``step`` and ``score`` among them; empty before the first validation."""
    extended: tuple[Extension, ...] = ()
    pending: bool = False
    """Whether this state has yet to be validated: a signal interrupted its validation."""

    @property
    def best_step(self) -> int | None:
        """Step of the best checkpoint; None before the first validation."""
        return int(self.best["step"]) if self.best else None

    def to_json(self) -> dict[str, Any]:
        """Plain values; ``extended`` is left out where there are no extensions, ``pending`` where it is False."""
        more: dict[str, Any] = {"extended": [one.to_json() for one in self.extended]} if self.extended else {}
        if self.pending:
            more["pending"] = True
        return {"best": self.best, **more}

    @classmethod
    def of(cls, values: Any, step: int) -> TrainerState:
        """Read what :meth:`to_json` wrote.

        Args:
            values: plain values; not trusted.
            step: steps of the checkpoint.

        Raises:
            DataError: figures or extensions are missing or of another form.
        """
        best = values.get("best") if isinstance(values, Mapping) else None
        if not isinstance(best, dict) or not all(_is_figure(name, value) for name, value in best.items()):
            raise DataError("no figures of the best checkpoint in it")
        at = best.get("step")
        if best and not (SCORE in best and type(at) is int and 0 <= at <= step):
            raise DataError("figures of the best checkpoint without its score and step")
        try:
            return cls(best, extensions(values.get("extended", [])), values.get("pending", False) is True)
        except ConfigError as error:
            raise DataError(str(error)) from None


def _is_figure(name: str, value: object) -> bool:
    """Whether name and value can be printed in a model card: a short printable name, a finite number."""
    known = name.isprintable() and len(name) <= _LONGEST_NAME
    return known and type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]
