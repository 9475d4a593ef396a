"""The common part of language models whose weights are on this machine."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from ucon.language.choice import Answer, Question
from ucon.language.models.weights import LocalWeights


class LocalModel(ABC):
    """A language model with weights on this machine; its answers have scores."""

    gives_scores = True
    kind = "local"
    """First part of the name."""
    from_command_line = ("download",)
    """A stored configuration may not switch downloads on; only the command line may."""

    def __init__(self, weights: LocalWeights) -> None:
        """Set the weights; nothing is read yet."""
        self._weights = weights

    @property
    def name(self) -> str:
        """Such as ``causal (Llama-3.1-8B-Instruct)``."""
        return f"{self.kind} ({self._weights.short})"

    def check(self) -> None:
        """Check that files, device and number format are there.

        See :meth:`ucon.language.choice.LanguageModel.check` for the errors.
        """
        self._weights.check()

    def fingerprint(self) -> str | None:
        """Checksum of the weights' files, None where there are none.

        It goes into the run's record (:mod:`ucon.evaluation.playing.needed_weights`).
        """
        return self._weights.fingerprint()

    @abstractmethod
    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer questions; see :meth:`ucon.language.choice.LanguageModel.answer`."""
