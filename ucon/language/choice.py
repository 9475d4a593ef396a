"""The interface of language models: closed questions in, a choice or a score for each option out.

Agents ask batches of :class:`Question`; a :class:`LanguageModel` answers each. A question has the text of its prompt
(for models that read prose) and the parts it was made of (for encoders, which compare texts, and for masked models,
which fill a gap). Whatever a habit or a server says, an answer is one of the options or none.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
"""(H, W, 3) RGB."""


#: Least log-probability in an answer's scores.
LEAST: Final = -1e4

Failure = Literal["", "server", "unusable", "too long"]
"""``server``: no answer in time, or a refusal. ``unusable``: no answer names exactly one option. ``too long``: the
question exceeds the model's window even without habits."""


@dataclass(frozen=True, slots=True)
class Option:
    """One of the possible answers."""

    name: str
    """The answer itself: ``front``, ``90``, ``sofa``. Unique within a question."""
    labels: tuple[str, ...] = ()
    """Categories, with spaces, of the things at this option; for models that compare texts."""


@dataclass(frozen=True, eq=False)
class Question:
    """One closed question."""

    target: str
    """Category of the target, with spaces."""
    habits: tuple[str, ...]
    """The sentences that the agent was given, in order."""
    options: tuple[Option, ...]
    """At least one."""
    system: str
    """System message: role, rules and habits. It is the same in all questions of an episode, for prefix caches."""
    situation: str
    """User message: what is seen now, the options and the question."""
    cloze: str = ""
    """A sentence with one ``{}`` for an option's name; for masked models, which read no instructions."""
    images: tuple[Image, ...] = ()
    """For vision-language models."""
    listed: Callable[[Sequence[int]], str] | None = None
    """Gives the user message with the options in another order (their numbers); None where it lists no options."""
    things: tuple[str, ...] = ()
    """For questions about which option is kept at a place (L3MVN): categories of the things there, with spaces."""
    weights: tuple[float, ...] = ()
    """How much each habit counts in the context that the agent was told, for models that compare texts; empty where
    none was told. Models that read prose find the context in ``system``."""


@dataclass(frozen=True, slots=True)
class Answer:
    """A model's answer to one question."""

    choice: int
    """Number of the option; -1 where there is no usable answer, so that the caller falls back."""
    scores: tuple[float, ...] = ()
    """Natural logarithms of the options' probabilities, which sum to 1; empty for models that only name an option."""
    text: str = ""
    """Generated text, cut to 500 characters; empty for models that score."""
    retries: int = 0
    """Further requests that were needed because an answer was unusable."""
    prompt_tokens: int = 0
    completion_tokens: int = 0
    seconds: float = 0.0
    """Wall time; in a batch an equal share, or the answer's own where requests run in parallel."""
    failure: Failure = ""
    """Why there is no usable answer; empty where there is one."""
    dropped: int = 0
    """Number of habits cut off at the end of the list because of the model's window."""
    places: tuple[int, ...] = ()
    """Place of the chosen option in the list, from 0, for each order in which the question was asked; empty for models
    that read no list."""


@runtime_checkable
class LanguageModel(Protocol):
    """Answers closed questions. Configured in ``configs/language/``; weights are loaded at the first question.

    A model that reads :attr:`Question.images` has ``sees_images = True``. One with weights on this machine has
    ``fingerprint()``, see :mod:`ucon.evaluation.playing.needed_weights`.
    """

    @property
    def name(self) -> str:
        """Kind and weights, for tables: ``encoder (all-MiniLM-L6-v2)``."""
        ...

    @property
    def gives_scores(self) -> bool:
        """Whether answers have scores; agents that compare options across questions need them."""
        ...

    def check(self) -> None:
        """Check that weights, or server and key, are there, before anything is played; cheap.

        Raises:
            ConfigError: an option that cannot work here, or a key that is missing or refused.
            DataError: weights that are missing.
            ServerError: a server that cannot be reached.
        """
        ...

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer a batch of questions.

        Returns:
            One answer per question, in order. A model's or server's failure is an answer without a choice, never an
                exception.
        """
        ...


def sees_images(model: LanguageModel) -> bool:
    """Whether a model reads the images of a question; other models would ignore them."""
    return bool(getattr(model, "sees_images", False))


def from_scores(logits: NDArray[np.floating[Any]], **spent: Any) -> Answer:
    """The answer of a model that scores; ties go to the first option.

    Args:
        logits: (n,) log odds of the options in natural units. If one is NaN, as with overflowing half precision, the
            answer has no choice. Impossible options get :data:`LEAST`, since records hold finite numbers.
        **spent: fields of :class:`Answer`.
    """
    x = np.asarray(logits, np.float64)
    if np.isnan(x).any() or not np.isfinite(x.max()):
        return Answer(-1, failure="unusable", **spent)
    x = np.maximum(x - x.max(), LEAST)
    scores = np.round(x - np.log(np.exp(x).sum()), 4) + 0.0
    return Answer(int(scores.argmax()), tuple(scores.tolist()), **spent)
