"""The record of one choice that an agent made: a line of ``decisions.jsonl``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.core.files import canonical_json
from ucon.core.text import shown
from ucon.core.untrusted.typed import read_as
from ucon.evaluation.kept.position_bias import PositionBias

_COUNTS: Final = (
    "number", "step", "chosen", "asked", "dropped", "retries", "prompt_tokens", "completion_tokens",
)  # fmt: skip


@dataclass(frozen=True)
class DecisionRecord:
    """One choice among candidates. Wall-clock seconds are stored elsewhere, since they differ from run to run."""

    episode: str
    number: int
    """Number of the decision in its episode, from 0."""
    step: int
    kind: str
    """Kind of the chosen candidate, ``target`` for approaching the seen target, or ``solution`` of the oracle."""
    options: tuple[str, ...]
    """The options in words: the candidates, or what stands for them (LGX by objects).

    A search that values every view lists only the chosen one.
    """
    chosen: int
    """Index of the chosen candidate; also of ``options``, except where these stand for candidates (LGX by objects)."""
    scores: tuple[float | None, ...] = ()
    """Scores of the options, where there are any; None in a stored line where one is not finite."""
    asked: int = 0
    """Number of questions to a language model."""
    fallback: bool = False
    """True where no usable answer came and the agent followed its rule for that case."""
    answered: int = -1
    """Index of the answered option; -1 for none (L3MVN compares probabilities of labels)."""
    dropped: int = 0
    """Habits that did not fit into the model's context window, in the question that lost the most."""
    failure: str = ""
    """Reason why no usable answer came."""
    retries: int = 0
    prompt_tokens: int = 0
    completion_tokens: int = 0
    text: str = ""
    """The model's answer as text, if any; control characters are replaced in a stored line.

    For computed choices: gain and cost of the chosen view.
    """
    places: tuple[int, ...] = ()
    """Place of the model's choice in the list of options, for each order in which it was asked; stored where there is
    one."""
    seconds: float = 0.0
    """Wall time of the answers; not part of the stored line."""

    @property
    def words(self) -> str:
        """The chosen option in words."""
        number = self.answered if self.answered >= 0 else self.chosen
        return self.options[number] if number < len(self.options) else self.kind

    def to_json(self) -> dict[str, Any]:
        """Plain values of the stored line, without seconds."""
        values: dict[str, Any] = asdict(self)
        values.pop("seconds")
        if not self.places:
            values.pop("places")
        values["scores"] = [float(s) if s is not None and isfinite(s) else None for s in self.scores]
        values["text"] = shown(self.text)  # a server's answer may contain control characters
        return values

    def to_line(self) -> str:
        """One line of canonical JSON, without the line break."""
        return canonical_json(self.to_json())

    @classmethod
    def from_json(cls, data: Any, *, where: str = "decision") -> DecisionRecord:
        """Read a record from a parsed line.

        Args:
            data: plain values; not trusted.
            where: file and line, for errors.

        Raises:
            DataError: it is malformed, or has negative counts.
        """
        without = ("seconds",) if isinstance(data, dict) and "places" in data else ("seconds", "places")
        decision = read_as(cls, data, where, "a decision", without=without)
        counts = (*(getattr(decision, name) for name in _COUNTS), *decision.places, decision.answered + 1)
        if min(counts) < 0:
            raise DataError(f"{where}: counts below 0; the file is altered, evaluate again")
        return decision


def language_figures(decisions: Sequence[DecisionRecord], n_episodes: int) -> dict[str, Any] | None:
    """Rates and costs of the language model over a run, for ``summary.json``.

    Args:
        decisions: of all episodes.
        n_episodes: number of episodes.

    Returns:
        None where no model was asked.
    """
    asked = _asked(decisions)
    if not asked or not n_episodes:
        return None
    failures = [d.failure or "unusable" for d in asked if d.fallback]
    bias = PositionBias.of(asked)
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
    } | ({} if bias is None else {"position_bias": bias.to_json()})


def seconds_per_decision(decisions: Sequence[DecisionRecord]) -> float | None:
    """Mean wall time of decisions for which a model was asked; None where none was."""
    asked = _asked(decisions)
    return sum(d.seconds for d in asked) / len(asked) if asked else None


def _asked(decisions: Sequence[DecisionRecord]) -> list[DecisionRecord]:
    return [d for d in decisions if d.asked]
