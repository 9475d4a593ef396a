"""Chat models on this machine: the score of an option is the log-probability that it is the answer.

The answer is the option's name and the end of the turn. Without the end, ``sofa`` would be at least as probable as
``sofa bed``, which begins with it. Log-probabilities are summed over tokens: the sum is the probability of the whole
answer. ``normalise`` takes the mean instead, for models that underrate long names.

A row of the network is one option of one question; rows of several questions go through it together. Other rows change
a row's scores by rounding only; with ``batch_size=1`` each row is read alone, and scores do not depend on others at
all.
"""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.language.choice import Answer, Question, from_scores
from ucon.language.models.conversation import ChatTemplate, end_tokens, window_of
from ucon.language.models.local import LocalModel
from ucon.language.models.weights import LocalWeights

Ids = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Ready:
    """A question as tokens, cut to the window by whole habits."""

    prompt: Ids
    """Tokens of the prompt."""
    dropped: int
    """Number of habits that were left out."""


R = TypeVar("R", bound=Ready)


class LikelihoodModel(LocalModel, Generic[R]):
    """A model that scores options by log-probability; subclasses tokenise questions and score batches of them."""

    auto = ""
    """Name of the transformers class that loads the weights."""

    def __init__(
        self,
        weights: LocalWeights,
        *,
        batch_size: int,
        normalise: bool,
        window: int | None,
        template: Mapping[str, Any] | None,
    ) -> None:
        """See :class:`.causal_lm.CausalModel` for arguments and errors."""
        if batch_size < 1 or (window is not None and window < 2):
            raise ConfigError(f"batch_size={batch_size}, window={window}: expected at least 1 and 2")
        super().__init__(weights)
        self._batch, self._normalise, self._limit, self._options = batch_size, normalise, window, template

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer questions; see :meth:`ucon.language.choice.LanguageModel.answer`.

        An answer's seconds are those of tokenising its question, and an equal share of its group's time in the network.
        """
        out: dict[int, Answer] = {}
        ready: dict[int, R] = {}
        spent: dict[int, float] = {}
        for i, question in enumerate(questions):
            start = time.perf_counter()
            found = self._ready(question)
            spent[i] = time.perf_counter() - start
            if found is None:
                out[i] = Answer(-1, failure="too long", seconds=spent[i])
            else:
                ready[i] = found
        for group in self._groups(ready):
            start = time.perf_counter()
            scores = self._scores([ready[i] for i in group])
            share = (time.perf_counter() - start) / len(group)
            for i, own in zip(group, scores, strict=True):
                told = {"prompt_tokens": len(ready[i].prompt), "dropped": ready[i].dropped}
                out[i] = from_scores(own, seconds=spent[i] + share, **told)
        return [out[i] for i in range(len(questions))]

    def _groups(self, ready: Mapping[int, R]) -> list[list[int]]:
        """Numbers of the questions that are scored together: of one kind, ``batch_size`` at most."""
        kinds: dict[Hashable, list[int]] = {}
        for i, one in ready.items():
            kinds.setdefault(self._kind(one), []).append(i)
        size = self._batch if self._together else 1
        return [group[i : i + size] for group in kinds.values() for i in range(0, len(group), size)]

    def _parts(self, group: Sequence[Sequence[Any]]) -> list[list[tuple[int, Any]]]:
        """Rows (number in the group, option) of some questions' options, ``batch_size`` at most a part."""
        rows = [(k, option) for k, options in enumerate(group) for option in options]
        return [rows[i : i + self._batch] for i in range(0, len(rows), self._batch)]

    def _log_prob(self, said: Any, answer: Sequence[int]) -> float:
        """Log-probability of an answer and the end of the turn.

        ``said`` (len(answer) + 1 or more, V) are the model's log-probabilities; ``said[0]`` predicts the first token.
        """
        tokens = said[range(len(answer)), list(answer)].double().sum()
        end = said[len(answer), self._ends].double().logsumexp(0)
        return float(tokens + end) / (len(answer) + 1 if self._normalise else 1)

    @abstractmethod
    def _ready(self, question: Question) -> R | None:
        """A question as tokens; None where it exceeds the window even without habits."""

    @abstractmethod
    def _scores(self, group: Sequence[R]) -> list[NDArray[np.float64]]:
        """Log-probabilities (n,) of the options of each question of a group."""

    def _kind(self, ready: R) -> Hashable:
        """Only questions of the same kind are scored together."""
        return None

    @property
    @abstractmethod
    def _together(self) -> bool:
        """Whether rows of different lengths may go through this network together."""

    @cached_property
    def _window(self) -> int:
        own = window_of(self._model)
        if self._limit is not None and self._limit > own:
            raise ConfigError(
                f"language.window={self._limit}: {self._weights.short} reads {own} tokens; give that or less, or null"
            )
        return self._limit or own

    @cached_property
    def _ends(self) -> list[int]:
        return end_tokens(self._model, self._tokenizer)

    @cached_property
    def _template(self) -> ChatTemplate:
        return ChatTemplate(self._owner, self._weights.path, self._options)

    @cached_property
    def _model(self) -> Any:
        return self._weights.load(self.auto)

    @property
    @abstractmethod
    def _owner(self) -> Any:
        """The tokenizer or processor, whichever has the chat template."""

    @property
    @abstractmethod
    def _tokenizer(self) -> Any:
        """The tokenizer."""
