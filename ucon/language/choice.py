"""Asking a language model to choose: a closed set of options in, a score for each out.

Agents ask :class:`Question` s, batches of them; a :class:`LanguageModel` answers each. A question carries the words of
its prompt (for models that read prose), and the parts it was made of (for encoders, which compare texts, and for masked
models, which fill a gap). Whatever a habit or a server says, an answer is one of the options or none at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
"""(H, W, 3) RGB."""


#: Least log-probability that an answer states.
LEAST: Final = -1e4

Failure = Literal["", "server", "unusable", "too long"]
"""``server``: no answer, a refusal or none in time; ``unusable``: answers, but none that names one option;
``too long``: a question that exceeds the model's window even without habits."""


@dataclass(frozen=True, slots=True)
class Option:
    """One of the things that may be answered."""

    name: str
    """The answer itself: ``front``, ``90``, ``sofa``. Names in one question differ."""
    labels: tuple[str, ...] = ()
    """Catalogue names, with spaces, of what stands there; for models that compare texts."""


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked of a model once."""

    target: str
    """The thing looked for, with spaces."""
    habits: tuple[str, ...]
    """The sentences that the agent was given, in order."""
    options: tuple[Option, ...]
    """At least one."""
    system: str
    """Role, rules and habits: the same in all questions of an episode, so that a prefix cache can keep it."""
    situation: str
    """What is seen now, and what is asked; it lists the options."""
    cloze: str = ""
    """A sentence with one ``{}`` that an option's name fills: for masked models, which read no instructions."""
    images: tuple[Image, ...] = ()
    """For models that see."""
    things: tuple[str, ...] = ()
    """Catalogue names, with spaces, of a place, where the question is which option is kept there (L3MVN); for models
    that compare texts."""


@dataclass(frozen=True, slots=True)
class Answer:
    """What a model said to one question."""

    choice: int
    """Number of the option, -1 where no usable answer came: the caller then falls back, and counts it."""
    scores: tuple[float, ...] = ()
    """Natural logarithms of the options' probabilities, which add up to 1; empty for models that only name one."""
    text: str = ""
    """What was generated, cut to 500 characters; empty for models that score."""
    retries: int = 0
    """Questions asked again because an answer was unusable."""
    prompt_tokens: int = 0
    completion_tokens: int = 0
    seconds: float = 0.0
    """Wall time of this answer; in a batch its share, or its own where answers are waited for side by side."""
    failure: Failure = ""
    """Why there is no usable answer; empty where there is one."""
    dropped: int = 0
    """Habits at the end of the list that did not fit into the model's window."""


@runtime_checkable
class LanguageModel(Protocol):
    """Answers questions. Built by ``configs/language/``; weights are loaded at the first question.

    A model that reads :attr:`Question.images` says ``sees_images = True``; one that says nothing reads words alone.
    One with weights on this machine has ``fingerprint()``, see :mod:`ucon.evaluation.playing.needed_weights`.
    """

    @property
    def name(self) -> str:
        """Names kind and weights in every table: ``encoder (all-MiniLM-L6-v2)``."""
        ...

    @property
    def gives_scores(self) -> bool:
        """Whether answers carry scores; agents that compare options across questions need them."""
        ...

    def check(self) -> None:
        """Whether weights, or server and key, are there: cheap, for one line of error before anything is played.

        Raises:
            ConfigError: an option that cannot work here, or a key that is missing or refused.
            DataError: weights that are missing.
            ServerError: a server that cannot be reached.
        """
        ...

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """One answer a question, in order; never an exception for what a model or a server says."""
        ...


def sees_images(model: LanguageModel) -> bool:
    """Whether a model reads the images of a question; those that cannot would answer without a word of complaint."""
    return bool(getattr(model, "sees_images", False))


def from_scores(logits: NDArray[np.floating[Any]], **spent: Any) -> Answer:
    """The answer of a model that scores: ``logits`` (n,) in natural units, rounded so that ties fall to the first.

    No answer where a logit is no number, as overflowing half precision makes them. What is impossible gets
    :data:`LEAST`, since records hold finite numbers.
    """
    x = np.asarray(logits, np.float64)
    if np.isnan(x).any() or not np.isfinite(x.max()):
        return Answer(-1, failure="unusable", **spent)
    x = np.maximum(x - x.max(), LEAST)
    scores = np.round(x - np.log(np.exp(x).sum()), 4) + 0.0
    return Answer(int(scores.argmax()), tuple(scores.tolist()), **spent)
