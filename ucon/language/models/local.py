"""What models of this machine have in common: a name by their weights, and checks of these."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from ucon.language.choice import Answer, Question
from ucon.language.models.weights import LocalWeights


class LocalModel(ABC):
    """A model whose weights are files here. It gives scores."""

    gives_scores = True
    kind = "local"
    """Before the weights in the name."""
    from_command_line = ("download",)
    """The network: a stored configuration does not decide that it is used."""

    def __init__(self, weights: LocalWeights) -> None:
        self._weights = weights

    @property
    def name(self) -> str:
        """Such as ``causal (Llama-3.1-8B-Instruct)``."""
        return f"{self.kind} ({self._weights.short})"

    def check(self) -> None:
        """See :meth:`ucon.language.choice.LanguageModel.check`."""
        self._weights.check()

    def fingerprint(self) -> str | None:
        """See :mod:`ucon.evaluation.playing.needed_weights`."""
        return self._weights.fingerprint()

    @abstractmethod
    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """See :class:`ucon.language.choice.LanguageModel`."""
