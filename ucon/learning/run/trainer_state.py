"""What a checkpoint holds of the trainer, beside the state of the learner."""

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
    """Validation figures of the best checkpoint with its step, and what the run was extended by before this state."""

    best: dict[str, float] = field(default_factory=dict)
    """Empty before the first validation."""
    extended: tuple[Extension, ...] = ()

    @property
    def best_step(self) -> int | None:
        """Of the best checkpoint."""
        return int(self.best["step"]) if self.best else None

    def to_json(self) -> dict[str, Any]:
        """Plain values; nothing is said of extensions where there are none."""
        more = {"extended": [one.to_json() for one in self.extended]} if self.extended else {}
        return {"best": self.best, **more}

    @classmethod
    def of(cls, values: Any, step: int) -> TrainerState:
        """What :meth:`to_json` wrote after ``step`` steps.

        Raises:
            DataError: it is something else.
        """
        best = values.get("best") if isinstance(values, Mapping) else None
        if not isinstance(best, dict) or not all(_is_figure(name, value) for name, value in best.items()):
            raise DataError("no figures of the best checkpoint in it")
        at = best.get("step")
        if best and not (SCORE in best and type(at) is int and 0 <= at <= step):
            raise DataError("figures of the best checkpoint without its score and step")
        try:
            return cls(best, extensions(values.get("extended", [])))
        except ConfigError as error:
            raise DataError(str(error)) from None


def _is_figure(name: str, value: object) -> bool:
    """Names are printed in the model card."""
    known = name.isprintable() and len(name) <= _LONGEST_NAME
    return known and type(value) in (int, float) and math.isfinite(value)  # type: ignore[arg-type]
