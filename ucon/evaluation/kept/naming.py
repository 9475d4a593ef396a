"""What a run is called in tables: the agent with the language model it asks and the detector, and its habit level.

An agent is what it asks: LGX with a sentence encoder and LGX with a language model of eight billion weights are two
rows. True labels (``gt``) are the usual ones and stay unsaid.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

#: In place of the habit level of an agent that plays all levels alike.
ANY_LEVEL = "any"


@dataclass(frozen=True)
class NameParts:
    """What ``summary.json`` says of a run's parts, so that tables can name them."""

    language_model: str | None = None
    """Name of the model that the agent asks; None where it asks none."""
    detector: str | None = None
    uses_habits: bool = True

    def to_json(self) -> dict[str, Any]:
        """JSON-ready dictionary."""
        return asdict(self)


def parts_of(agent: Any, detector: Any) -> NameParts:
    """The parts of an agent and the detector that its environment has."""
    model, uses_habits = getattr(agent, "language", None), getattr(agent, "uses_habits", True)
    return NameParts(getattr(model, "name", None), getattr(detector, "name", None), bool(uses_habits))


def player(summary: Mapping[str, Any]) -> str:
    """Who played, by a ``summary.json``: ``lgx + encoder (all-MiniLM-L6-v2) + noisy``."""
    detector = summary.get("detector")
    parts = [summary["agent"], summary.get("language_model"), None if detector == "gt" else detector]
    return " + ".join(part for part in parts if part)


def level(summary: Mapping[str, Any]) -> str:
    """The habit level; ``any`` for an agent that reads no habits, whichever it happened to be played at."""
    return str(summary["habit_level"]) if summary.get("uses_habits", True) else ANY_LEVEL


def answers_something(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Whether ``a - b`` is worth a row of a sweep: a level of a player minus its basis, or two players at one level.

    A player that reads no habits is at every level at once.
    """
    first, second, levels = player(a), player(b), (level(a), level(b))
    if first == second:
        return levels == ("context", "retrieval") or (levels[1] == "none" != levels[0])
    if ANY_LEVEL in levels and levels[0] != levels[1]:
        return levels[1] == ANY_LEVEL  # what reads no habits is the basis
    return levels[0] == levels[1] and first < second
