"""How a language model's choices depend on places in the list of options, and on the options' names alone.

A model that reads the options chooses every place in the list equally often; small models do not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol

from ucon.core.errors import DataError

#: Names of options are counted if there are at most this many different ones.
_FEW_NAMES: Final = 8


class Listed(Protocol):
    """The parts of a decision (:class:`ucon.evaluation.kept.decisions.DecisionRecord`) that are counted."""

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the options."""
        ...

    @property
    def answered(self) -> int:
        """Index of the answered option; -1 for none."""
        ...

    @property
    def places(self) -> tuple[int, ...]:
        """Place of the model's choice in the list, for each order in which it was asked."""
        ...


@dataclass(frozen=True)
class PositionBias:
    """Shares of choices over a run."""

    chosen: Mapping[int, tuple[int, tuple[float, ...]]]
    """By number of options: number of choices in all orders, and the share of each place in the list."""
    agreement: float | None
    """Share of the decisions asked in two orders in which both chose the same option; None where none was."""
    named: Mapping[str, float]
    """Share of each name among the answers, where there are few names, such as directions; else empty."""

    @classmethod
    def of(cls, decisions: Sequence[Listed]) -> PositionBias | None:
        """Count the choices of a run; None where no model read a list.

        Args:
            decisions: of all episodes.
        """
        listed = [d for d in decisions if d.places]
        if not listed:
            return None
        chosen = {}
        for n in sorted({len(d.options) for d in listed}):
            places = [place for d in listed if len(d.options) == n for place in d.places]
            chosen[n] = len(places), tuple(places.count(k) / len(places) for k in range(n))
        # The second order is the first one reversed: the two places of an option add up to the last place's number.
        same = [sum(d.places) == len(d.options) - 1 for d in listed if len(d.places) == 2]
        names = sorted({name for d in listed for name in d.options})
        answers = [d.options[d.answered] for d in listed if 0 <= d.answered < len(d.options)]
        few = len(names) <= _FEW_NAMES and answers
        return cls(
            chosen,
            sum(same) / len(same) if same else None,
            {name: answers.count(name) / len(answers) for name in names} if few else {},
        )

    def to_json(self) -> dict[str, Any]:
        """Plain values for ``summary.json``."""
        chosen = {str(n): {"choices": count, "shares": list(shares)} for n, (count, shares) in self.chosen.items()}
        return {"chosen": chosen, "agreement": self.agreement, "named": dict(self.named)}

    @classmethod
    def in_summary(cls, summary: Mapping[str, Any], where: str = "summary") -> PositionBias | None:
        """Read the shares from a summary; None where it has none.

        Args:
            summary: content of ``summary.json``; not trusted.
            where: names the file in errors.

        Raises:
            DataError: they are malformed.
        """
        language = summary.get("language")
        if not isinstance(language, dict) or "position_bias" not in language:
            return None
        try:
            found = language["position_bias"]
            chosen = {
                int(n): (_count(one["choices"]), tuple(map(_share, one["shares"])))
                for n, one in found["chosen"].items()
            }
            agreement = None if found["agreement"] is None else _share(found["agreement"])
            named = {str(name): _share(share) for name, share in found["named"].items()}
            if any(len(shares) != n for n, (_, shares) in chosen.items()):
                raise ValueError
        except (LookupError, TypeError, ValueError, AttributeError):
            raise DataError(f"{where}: position_bias is malformed; the file is altered, evaluate again") from None
        return cls(chosen, agreement, named)


def _count(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise ValueError
    return value


def _share(value: Any) -> float:
    if type(value) not in (int, float) or not 0 <= value <= 1:
        raise ValueError
    return float(value)
