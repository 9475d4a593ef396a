"""Verdicts of validation: which placements could be realised in which home in PyBullet, and the reason where not.

A verdict is about a triple (category, relation, anchor). A home in which it was tried has its own reason; elsewhere a
triple counts as implausible only if every home in which it was tried refused it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

#: Reasons that hold for one home only: another one may have the anchor.
_OF_THE_HOME = frozenset({"absent_anchor", "not_importable"})

Triple = tuple[str, str, str]
"""Category, relation, anchor."""
NEVER_SEEN: Final = "never_seen"
"""Reason: it was placed and settled, but is visible from no pose within reach."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """The result of trying a triple.

    Attributes:
        tried: number of homes in which it was tried.
        refused: by home that refused it, the reason.
    """

    tried: int
    refused: Mapping[str, str] = field(default_factory=dict)

    @property
    def reason(self) -> str | None:
        """Why the triple is implausible in every home: its most frequent reason.

        None if some home could realise it, or if no home in which it was tried has the anchor.
        """
        if not self.tried or len(self.refused) < self.tried:
            return None
        reasons = [reason for reason in self.refused.values() if reason not in _OF_THE_HOME]
        return max(sorted(set(reasons)), key=reasons.count) if reasons else None


@dataclass(frozen=True)
class Verdicts:
    """All verdicts of a dataset, by triple; empty where it was not validated."""

    of: Mapping[Triple, Verdict] = field(default_factory=dict)

    def refusal(self, triple: Triple, home: str) -> str | None:
        """Why a triple cannot be realised in a home.

        Args:
            triple: category, relation, anchor.
            home: its name.

        Returns:
            None where it can be realised, or was not tried.
        """
        verdict = self.of.get(triple)
        if verdict is None:
            return None
        return verdict.refused.get(home) or verdict.reason

    def to_json(self) -> list[list[Any]]:
        """JSON rows, sorted: category, relation, anchor, homes tried, reason by home."""
        return [[*triple, v.tried, dict(sorted(v.refused.items()))] for triple, v in sorted(self.of.items())]

    @classmethod
    def from_json(cls, rows: list[list[Any]]) -> Verdicts:
        """Read verdicts from JSON rows.

        Raises:
            ValueError: a row has another length, or a value another type.
            TypeError: the same, by type.
        """
        found: dict[Triple, Verdict] = {}
        for category, relation, anchor, tried, refused in rows:
            reasons = {str(home): str(reason) for home, reason in refused.items()}
            found[str(category), str(relation), str(anchor)] = Verdict(int(tried), reasons)
        return cls(found)


NO_VERDICTS = Verdicts()
