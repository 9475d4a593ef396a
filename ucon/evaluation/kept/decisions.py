"""What is kept of one choice that an agent made: a line of ``decisions.jsonl``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.core.files import canonical_json
from ucon.core.text import shown
from ucon.core.untrusted.typed import read_as

_COUNTS: Final = (
    "number", "step", "chosen", "asked", "dropped", "retries", "prompt_tokens", "completion_tokens",
)  # fmt: skip


@dataclass(frozen=True)
class DecisionRecord:
    """One choice among candidates. Wall-clock seconds are kept apart: they differ from run to run."""

    episode: str
    number: int
    """Of the episode, from 0."""
    step: int
    kind: str
    """Of what was chosen: a candidate's, ``target`` that was seen, or the ``solution`` that an oracle walks."""
    options: tuple[str, ...]
    """What it was chosen from, in words: candidates, or (LGX by objects) what stands for them; of searches that value
    every view, the chosen one alone."""
    chosen: int
    """Number of the candidate. It numbers ``options`` too, but where they stand for candidates (LGX by objects)."""
    scores: tuple[float | None, ...] = ()
    """Of the options, where the chooser gives any; None in a line where one is not finite."""
    asked: int = 0
    """Questions put to a language model."""
    fallback: bool = False
    """Whether no usable answer came and the agent chose by its rule for that."""
    answered: int = -1
    """Number of the option that was answered; -1 where none was (L3MVN compares probabilities of labels)."""
    dropped: int = 0
    """Habits that did not fit into the model's window, in the question that lost most."""
    failure: str = ""
    """Why not."""
    retries: int = 0
    prompt_tokens: int = 0
    completion_tokens: int = 0
    text: str = ""
    """What the model said, where it says something; without line breaks and other control characters in the line. Of
    choices that are computed: what the chosen view is worth and costs."""
    seconds: float = 0.0
    """Wall time of the answers; not part of the line."""

    @property
    def words(self) -> str:
        """What was chosen, in words."""
        number = self.answered if self.answered >= 0 else self.chosen
        return self.options[number] if number < len(self.options) else self.kind

    def to_json(self) -> dict[str, Any]:
        """What is kept of it, JSON-ready."""
        values: dict[str, Any] = asdict(self)
        values.pop("seconds")
        values["scores"] = [float(s) if s is not None and isfinite(s) else None for s in self.scores]
        values["text"] = shown(self.text)  # servers say anything
        return values

    def to_line(self) -> str:
        """One line of canonical JSON without the line break."""
        return canonical_json(self.to_json())

    @classmethod
    def from_json(cls, data: Any, *, where: str = "decision") -> DecisionRecord:
        """Rebuild a record from a parsed line; raises :class:`DataError` where it is none."""
        decision = read_as(cls, data, where, "a decision", without=("seconds",))
        if min(getattr(decision, name) for name in _COUNTS) < 0 or decision.answered < -1:
            raise DataError(f"{where}: counts below 0; the file is altered, evaluate again")
        return decision


def language_figures(decisions: Sequence[DecisionRecord], n_episodes: int) -> dict[str, Any] | None:
    """Rates and costs of a run's decisions for ``summary.json``; None where no model was asked."""
    asked = _asked(decisions)
    if not asked or not n_episodes:
        return None
    failures = [d.failure or "unusable" for d in asked if d.fallback]
    return {
        "decisions": len(decisions),
        "decisions_per_episode": len(decisions) / n_episodes,
        "questions_per_episode": sum(d.asked for d in asked) / n_episodes,
        "fallback_rate": len(failures) / len(asked),
        "failures": {name: failures.count(name) for name in sorted(set(failures))},
        "dropped_rate": sum(d.dropped > 0 for d in asked) / len(asked),
        "dropped_per_decision": sum(d.dropped for d in asked) / len(asked),
        "retries": sum(d.retries for d in asked),
        "prompt_tokens_per_decision": sum(d.prompt_tokens for d in asked) / len(asked),
        "completion_tokens_per_decision": sum(d.completion_tokens for d in asked) / len(asked),
    }


def seconds_per_decision(decisions: Sequence[DecisionRecord]) -> float | None:
    """Mean wall time of those that a model was asked for; None where none was."""
    asked = _asked(decisions)
    return sum(d.seconds for d in asked) / len(asked) if asked else None


def _asked(decisions: Sequence[DecisionRecord]) -> list[DecisionRecord]:
    return [d for d in decisions if d.asked]
