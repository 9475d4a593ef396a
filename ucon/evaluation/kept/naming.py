"""Labels of runs in tables: the agent with its language model and detector, and the habit level.

LGX with a sentence encoder and LGX with an 8B language model are two rows. The default detector, true labels (``gt``),
is not named.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

#: Label of the habit level for an agent that reads no habits.
ANY_LEVEL = "any"


@dataclass(frozen=True)
class NameParts:
    """Parts of a run that ``summary.json`` names, for labels in tables."""

    language_model: str | None = None
    """Name of the agent's language model; None if it has none."""
    detector: str | None = None
    uses_habits: bool = True
    memory: str | None = None
    """Name of the memory, with ``task=resident``; None, and then not in the file, without one."""

    def to_json(self) -> dict[str, Any]:
        """Plain values by name."""
        return {name: value for name, value in asdict(self).items() if name != "memory" or value is not None}


def parts_of(agent: Any, detector: Any, memory: Any = None) -> NameParts:
    """Names of an agent's language model, of its environment's detector, and of its memory.

    Args:
        agent: may have ``language`` and ``uses_habits``.
        detector: may have ``name``.
        memory: may have ``name``, and ``uses_habits`` where it reads habits for an agent that reads none itself.
    """
    model = getattr(agent, "language", None)
    uses_habits = getattr(agent, "uses_habits", True) or getattr(memory, "uses_habits", False)
    model_name, detector_name, memory_name = (getattr(part, "name", None) for part in (model, detector, memory))
    return NameParts(model_name, detector_name, bool(uses_habits), memory_name)


def agent_label(summary: Mapping[str, Any]) -> str:
    """Label of the agent with its parts, such as ``lgx + encoder (all-MiniLM-L6-v2) + noisy``.

    Args:
        summary: content of ``summary.json``.
    """
    detector = summary.get("detector")
    memory = summary.get("memory")
    parts = [summary["agent"], summary.get("language_model"), None if detector == "gt" else detector]
    parts.append(memory and f"memory of {memory}")
    return " + ".join(part for part in parts if part)


def level(summary: Mapping[str, Any]) -> str:
    """Label of the habit level; ``any`` for an agent that reads no habits, whichever level it was played at.

    Args:
        summary: content of ``summary.json``.
    """
    return str(summary["habit_level"]) if summary.get("uses_habits", True) else ANY_LEVEL


def is_worth_comparing(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Whether ``a - b`` deserves a row in the comparison of a sweep.

    It does for a habit level minus its baseline of the same agent, and for two agents at one level. An agent that reads
    no habits counts as being at every level.

    Args:
        a: content of a ``summary.json``.
        b: content of another.
    """
    first, second, levels = agent_label(a), agent_label(b), (level(a), level(b))
    if first == second:
        return levels == ("context", "retrieval") or (levels[1] == "none" != levels[0])
    if ANY_LEVEL in levels and levels[0] != levels[1]:
        return levels[1] == ANY_LEVEL  # the agent that reads no habits is the baseline
    return levels[0] == levels[1] and first < second
