"""What a language model says about where the target is: one closed question an episode, as one more belief.

Optional: any backend of ``configs/language``. The options are the anchors that the reader knows.
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
    """Asks a language model once an episode."""

    def __init__(self, language: LanguageModel) -> None:
        """``language``: that scores options, or names one."""
        self._language = language

    @property
    def name(self) -> str:
        """Of the model."""
        return self._language.name

    def check(self) -> None:
        """See :meth:`ucon.language.choice.LanguageModel.check`."""
        self._language.check()

    def fingerprint(self) -> str | None:
        """Which weights it has, see :mod:`ucon.evaluation.playing.needed_weights`."""
        return fingerprint_of(self._language)

    def advice(self, info: Mapping[str, Any], anchors: Sequence[str]) -> NDArray[np.float64]:
        """Probability (A,) of each anchor; all its mass on one where a model only names one; uniform without answer."""
        answer = self._language.answer([self._question(info, anchors)])[0]
        if answer.choice < 0:
            return np.full(len(anchors), 1.0 / len(anchors))
        if answer.scores:
            return np.exp(np.array(answer.scores))
        return np.eye(len(anchors))[answer.choice]

    def _question(self, info: Mapping[str, Any], anchors: Sequence[str]) -> Question:
        target, habits = phrase(str(info["target"])), tuple(info["habits"])
        names = [phrase(anchor) for anchor in anchors]
        return Question(
            target=target,
            habits=habits,
            options=tuple(Option(name, (name,)) for name in names),
            system=_SYSTEM.format(habits=habit_block(habits)),
            situation=_SITUATION.format(target=target, options=", ".join(names)),
            cloze=f"The {target} is near the {{}}.",
        )
