"""Verdicts of validation: which placements hold in which home, tried in PyBullet, and why the others do not.

A verdict speaks of a triple (category, relation, anchor). A home in which it was tried has its own; elsewhere a triple
counts as implausible only where every home that was tried refused it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

#: Reasons that speak of the home, not of the triple: elsewhere the anchor may stand.
_OF_THE_HOME = frozenset({"absent_anchor", "not_importable"})

Triple = tuple[str, str, str]
"""Category, relation, anchor."""
NEVER_SEEN: Final = "never_seen"
"""Reason of what was placed and settled, but no pose in reach shows it."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a triple did: homes in which it was tried, and the reason in each home that refused it."""

    tried: int
    refused: Mapping[str, str] = field(default_factory=dict)

    @property
    def reason(self) -> str | None:
        """Why the triple is implausible everywhere: its most frequent reason; None where some home takes it.

        None as well where no home that was tried has the anchor.
        """
        if not self.tried or len(self.refused) < self.tried:
            return None
        reasons = [reason for reason in self.refused.values() if reason not in _OF_THE_HOME]
        return max(sorted(set(reasons)), key=reasons.count) if reasons else None


@dataclass(frozen=True)
class Verdicts:
    """All verdicts of a dataset; empty where it was not validated."""

    of: Mapping[Triple, Verdict] = field(default_factory=dict)

    def refusal(self, triple: Triple, home: str) -> str | None:
        """Why a triple cannot be realised in a home; None where it can, or nothing is known."""
        verdict = self.of.get(triple)
        if verdict is None:
            return None
        return verdict.refused.get(home) or verdict.reason

    def to_json(self) -> list[list[Any]]:
        """JSON-ready rows, sorted: category, relation, anchor, homes tried, reason by home."""
        return [[*triple, v.tried, dict(sorted(v.refused.items()))] for triple, v in sorted(self.of.items())]

    @classmethod
    def from_json(cls, rows: list[list[Any]]) -> Verdicts:
        """Rebuild them; raises ValueError or TypeError for what is not a list of rows."""
        found: dict[Triple, Verdict] = {}
        for category, relation, anchor, tried, refused in rows:
            reasons = {str(home): str(reason) for home, reason in refused.items()}
            found[str(category), str(relation), str(anchor)] = Verdict(int(tried), reasons)
        return cls(found)


NO_VERDICTS = Verdicts()
