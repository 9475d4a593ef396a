"""``encoder``: scores options by sentence vectors of habits and labels. The default language model.

Nothing is downloaded, and the vectors of catalogue names and the habit book are shipped. The relevance of a label l is
``(1 - beta) cos(l, target) + beta S(l)``, where S(l) is a soft maximum over habits h of ``cos(l, h)``. Each habit is
weighted by how much it is about the target: ``softmax(cos(h, target) / tau_habit)``. Without habits it is
``cos(l, target)``. The odds of an option's labels are added up.

Questions with :attr:`~ucon.language.choice.Question.things` are answered by :mod:`ucon.language.models.keeping`.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.language.choice import Answer, Option, Question, from_scores
from ucon.language.encoder import minilm_folder
from ucon.language.models.keeping import LocationScores, LocationWeights
from ucon.language.store import StoredEncoder, default_encoder
from ucon.objects.catalogue import catalogue

Vector = NDArray[np.float64]

#: Episodes whose relevances are kept, since several are played in parallel.
_EPISODES = 64
#: Log odds of the target itself among the labels, instead of a similarity. In the fit it is never among the labels.
FOUND = 30.0


@dataclass(frozen=True)
class EncoderWeights:
    """Fitted temperatures and mixing weights, the same at all habit levels.

    Fitted on the ``val`` episodes by ``python -m ucon data fit-language-encoder``, which describes the fit; raw cosines
    are too flat to decide anything. Nats of the true category among those of the home, ``none`` / ``full`` / ``gt`` /
    ``retrieval``, and of a uniform guess: val 4.270 / 3.793 / 3.639 / 3.706 (4.303), test 4.248 / 3.893 / 3.722 / 3.795
    (4.292). Adding up the odds of an option's labels is better than taking the largest (val, four options that share a
    home: 1.341 against 1.399, uniform 1.386).
    """

    beta: float = 1.886
    """Weight of the habits. Above 1, similarity to the target itself counts against a label: things with similar names
    are rarely kept in each other."""
    tau: float = 0.103
    """Increase of relevance that makes a label e times as probable, with habits."""
    tau_none: float = 0.3689
    """The same without habits."""
    tau_habit: float = 0.0779
    """Increase of similarity to the target that makes a habit count e times as much."""
    sigma: float = 0.1055
    """Softness of the maximum over habits."""
    empty: float = 0.286
    """Relevance of an option without labels, with habits."""
    empty_none: float = 0.793
    """The same without habits."""


class _Reading:
    """What the habits of one episode say: a logit for each label, computed once."""

    def __init__(self, target: Vector, habits: Vector, weights: EncoderWeights, counts: Sequence[float] = ()) -> None:
        """``target`` (D,), ``habits`` (H, D) unit vectors; H may be 0. ``counts`` (H,): how much each counts, or ()."""
        self._target, self._habits, self._w = target, habits, weights
        about = habits @ target / weights.tau_habit  # (H,)
        if counts:
            about = about + np.log(counts)
        self._log_share = about - np.logaddexp.reduce(about) if len(about) else about
        self.logits: dict[str, float] = {}

    def logit(self, label: Vector) -> float:
        """Log odds of a label (D,). One label at a time, so that its bytes do not depend on the others."""
        w, like = self._w, float(label @ self._target)
        if not len(self._habits):
            return like / w.tau_none
        said = float(w.sigma * np.logaddexp.reduce(self._log_share + self._habits @ label / w.sigma))
        return ((1.0 - w.beta) * like + w.beta * said) / w.tau

    @property
    def empty(self) -> float:
        """Log odds of an option without labels."""
        w = self._w
        return w.empty / w.tau if len(self._habits) else w.empty_none / w.tau_none


class EncoderModel:
    """Scores options by sentence vectors, one question at a time in float64."""

    name = "encoder (all-MiniLM-L6-v2)"
    gives_scores = True

    def __init__(
        self,
        weights: EncoderWeights | None = None,
        encoder: StoredEncoder | None = None,
        keeping: LocationWeights | None = None,
    ) -> None:
        """Choose weights and encoder; nothing is read yet.

        Args:
            weights: fitted numbers.
            encoder: makes vectors; by default the shipped table with MiniLM behind it.
            keeping: fitted numbers for questions with ``things``.
        """
        self._weights = weights or EncoderWeights()
        self._encoder = encoder
        self._vectors: dict[str, Vector] = {}
        self._readings: OrderedDict[tuple[str, tuple[str, ...], tuple[float, ...]], _Reading] = OrderedDict()
        self._keeping = LocationScores(self._encode, keeping)

    def check(self) -> None:
        """Check that MiniLM is installed, which texts outside the shipped table need.

        Raises:
            DataError: it is not.
        """
        if self._encoder is None:
            minilm_folder()

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """Answer questions; see :meth:`ucon.language.choice.LanguageModel.answer`."""
        return [self._answer(question) for question in questions]

    def _answer(self, question: Question) -> Answer:
        start = time.perf_counter()
        if question.things:
            return from_scores(self._keeping.logits(question), seconds=time.perf_counter() - start)
        reading = self._reading(question.target, question.habits, question.weights)
        logits = np.asarray([self._option(reading, option) for option in question.options])
        return from_scores(logits, seconds=time.perf_counter() - start)

    def label_logit(self, target: str, habits: tuple[str, ...], counts: tuple[float, ...], label: str) -> float:
        """Log odds of one label; ``counts``: how much each habit counts, or ()."""
        return self._reading(target, habits, counts).logit(self._vector(label))

    def _option(self, reading: _Reading, option: Option) -> float:
        labels = option.labels or _catalogue_name(option.name)
        if not labels:
            return reading.empty
        for label in labels:
            if label not in reading.logits:
                reading.logits[label] = reading.logit(self._vector(label))
        return float(np.logaddexp.reduce([reading.logits[label] for label in dict.fromkeys(labels)]))

    def _reading(self, target: str, habits: tuple[str, ...], counts: tuple[float, ...] = ()) -> _Reading:
        key = (target, habits, counts)
        if key in self._readings:
            self._readings.move_to_end(key)
            return self._readings[key]
        reading = self._readings[key] = _Reading(self._vector(target), self._encode(habits), self._weights, counts)
        reading.logits[target] = FOUND
        if len(self._readings) > _EPISODES:
            self._readings.popitem(last=False)
        return reading

    def _vector(self, text: str) -> Vector:
        if text not in self._vectors:
            self._vectors[text] = self._encode([text])[0]
        return self._vectors[text]

    def _encode(self, texts: Sequence[str]) -> Vector:
        """Unit vectors (n, D)."""
        return self._source.encode_half([_clean(text) for text in texts]).astype(np.float64)

    @property
    def _source(self) -> StoredEncoder:
        if self._encoder is None:
            self._encoder = default_encoder()
        return self._encoder


def _catalogue_name(name: str) -> tuple[str, ...]:
    """The name as its own label where it is a thing of the catalogue: ``sofa``, not ``front``."""
    plain = name.replace("_", " ")
    return (plain,) if plain.replace(" ", "_") in catalogue() else ()


def _clean(text: str) -> str:
    """The text with lone surrogates replaced, which cannot be hashed as UTF-8."""
    return text.encode("utf-8", "replace").decode()
