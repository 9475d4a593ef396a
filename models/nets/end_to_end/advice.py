"""A language model's answer to "where is the target kept?", asked once per episode, as a further feature of things.

Optional; any backend of ``configs/language``. The options are the anchors that the reader knows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.fingerprint import fingerprint_of
from ucon.language.choice import LanguageModel, Option, Question
from ucon.language.phrases import phrase
from ucon.language.prompt import habit_block

_SYSTEM = "You help a robot that searches a home for an object. What is known of the people who live there:\n{habits}"
_SITUATION = (
    "The robot looks for: {target}. On, in, under or next to which of these is it kept?\n{options}\nAnswer with one."
)


class Advisor:
    """Asks a language model once per episode."""

    def __init__(self, language: LanguageModel) -> None:
        """Wrap a language model.

        Args:
            language: gives scores of options, or names one.
        """
        self._language = language

    @property
    def name(self) -> str:
        """Name of the language model."""
        return self._language.name

    def check(self) -> None:
        """Raise a one-line error where the model's weights or its server's key are missing."""
        self._language.check()

    def fingerprint(self) -> str | None:
        """Hash of the model's weights; None where they are missing.

        See :mod:`ucon.evaluation.playing.needed_weights`.
        """
        return fingerprint_of(self._language)

    def advice(self, info: Mapping[str, Any], anchors: Sequence[str]) -> NDArray[np.float64]:
        """Probability of each anchor.

        All of it is on one anchor where the model only names one; it is uniform where the answer was unusable.

        Args:
            info: of the episode's reset; has the target and the habits.
            anchors: A categories.

        Returns:
            (A,) float64.
        """
        answer = self._language.answer([self._question(info, anchors)])[0]
        if answer.choice < 0:
            return np.full(len(anchors), 1.0 / len(anchors))
        if answer.scores:
            return np.exp(np.array(answer.scores))
        return np.eye(len(anchors))[answer.choice]

    def _question(self, info: Mapping[str, Any], anchors: Sequence[str]) -> Question:
        target, habits = phrase(str(info["target"])), tuple(info["habits"])
        names = [phrase(anchor) for anchor in anchors]

        def told(order: Sequence[int]) -> str:
            return _SITUATION.format(target=target, options=", ".join(names[k] for k in order))

        return Question(
            target=target,
            habits=habits,
            options=tuple(Option(name, (name,)) for name in names),
            system=_SYSTEM.format(habits=habit_block(habits)),
            situation=told(range(len(names))),
            cloze=f"The {target} is near the {{}}.",
            listed=told,
        )
