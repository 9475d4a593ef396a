"""Step 3 of the pipeline as the paper has it: a language model is asked whether a sentence speaks for a placement.

Any model of ``configs/language`` that gives scores will do. :mod:`ucon.generation.verify` has the verifier that was
fitted for the purpose.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from ucon.core.errors import ConfigError
from ucon.habits.types import Placement
from ucon.language.choice import LanguageModel, Option, Question
from ucon.language.phrases import phrase
from ucon.language.prompt import Prompt, neutral
from ucon.readers.reader_weights import Array

PROMPT: Final = Path(__file__).parent / "prompts" / "verify.txt"
_ANSWERS: Final = ("yes", "no")
_RELATIONS: Final = {"ontop": "on top of", "inside": "inside", "under": "under", "nextto": "next to"}
#: Score of a pair whose question has no usable answer.
UNKNOWN: Final = 0.5


class AskedVerifier:
    """Scores sentences against placements by the probability of ``yes``."""

    def __init__(self, language: LanguageModel) -> None:
        """Set the language model.

        Args:
            language: one that gives scores.

        Raises:
            ConfigError: it gives none.
        """
        if not language.gives_scores:
            raise ConfigError(f"{language.name} gives no probabilities; choose language=causal_lm or smollm2")
        self._language, self._prompt = language, Prompt.load(PROMPT)

    def scores(self, texts: Sequence[str], placements: Sequence[Placement]) -> Array:
        """Probability that each sentence supports each placement.

        Args:
            texts: H sentences.
            placements: P placements.

        Returns:
            (H, P) float64; :data:`UNKNOWN` where the model gave no usable answer.
        """
        pairs = [(text, placement) for text in texts for placement in placements]
        return self.of_pairs(pairs).reshape(len(texts), len(placements))

    def of_pairs(self, pairs: Sequence[tuple[str, Placement]]) -> Array:
        """As :meth:`scores`, for n pairs: (n,) float64."""
        answers = self._language.answer([self._question(*pair) for pair in pairs])
        return np.array([np.exp(answer.scores[0]) if answer.scores else UNKNOWN for answer in answers])

    def _question(self, text: str, placement: Placement) -> Question:
        place = f"{_RELATIONS[placement.relation]} the {phrase(placement.anchor)}"

        def told(order: Sequence[int]) -> str:
            names = ", ".join(_ANSWERS[k] for k in order)
            return self._prompt.situation(sentence=neutral(text), place=place, options=names)

        options = tuple(Option(name) for name in _ANSWERS)
        return Question("", (), options, self._prompt.system(), told(range(len(options))), listed=told)
