"""Scores which label is kept at a place with given things, by sentence vectors: the encoder's answer for L3MVN.

The log odds of a label l at a place with things o are ``weight * log((doubt + S) / (doubt + N))``. N is the number of
habits about the label: each habit h counts by its share ``softmax(cos(h, l) / about)`` among the labels and one more
answer, "about none of them", whose similarity is ``named``. S sums the same shares, each times how much better the
habit fits the place than furniture in general: the mean of ``exp((cos(h, o) - other * cos(l, o)) / sigma)`` over the
things divided by that over all furniture of the catalogue. The part with ``other`` removes what the habit shares with a
thing by naming its own label: a sentence about a pot is similar to every other pot. So a habit raises the label that it
is about where it fits the things there, lowers it where it does not, and does not affect others; a label that no habit
is about has 0. Without habits the log odds are ``like`` times the mean of ``cos(l, o)`` above that over furniture.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ucon.language.choice import Question
from ucon.language.phrases import phrase
from ucon.objects.catalogue import catalogue

Vectors = NDArray[np.float64]

#: Episodes whose terms are kept, since several are played in parallel.
_EPISODES = 64


@dataclass(frozen=True)
class LocationWeights:
    """Fitted numbers, the same at all habit levels.

    Fitted on the ``val`` episodes by ``python -m ucon data fit-location-model``, which describes the fit. Share of
    homes where the true one of four places is the most probable, and its nats, ``none`` / ``full`` / ``gt`` /
    ``retrieval``: val 0.325 / 0.395 / 0.400 / 0.395 (chance 0.25), 1.374 / 1.309 / 1.281 / 1.279 (uniform 1.386); test
    0.315 / 0.397 / 0.426 / 0.425, 1.372 / 1.322 / 1.277 / 1.283.
    """

    like: float = 8.81
    """Weight of the similarity of label and things, without habits."""
    other: float = 0.56
    """Share of the similarity of label and thing that is subtracted from that of habit and thing."""
    about: float = 0.0138
    """Increase of similarity to a label that makes a habit e times as likely to be about it."""
    named: float = 0.503
    """Similarity below which a habit is more likely about none of the labels."""
    sigma: float = 0.0408
    """Increase of similarity to a thing that makes a habit fit it e times as well."""
    weight: float = 0.7594
    """Weight of the habits."""
    doubt: float = 0.2904
    """Weight of the prior, as a number of habits."""


class LocationScores:
    """Answers questions with ``things``; the terms of an episode's habits are computed once."""

    def __init__(self, encode: Callable[[Sequence[str]], Vectors], weights: LocationWeights | None = None) -> None:
        """Choose encoder and weights.

        Args:
            encode: from n texts to unit vectors (n, D) float64.
            weights: fitted numbers; defaults where None.
        """
        self._encode = encode
        self._weights = weights or LocationWeights()
        self._furniture: Vectors | None = None
        self._readings: OrderedDict[tuple[tuple[str, ...], tuple[str, ...], tuple[float, ...]], _Reading] = (
            OrderedDict()
        )

    def logits(self, question: Question) -> Vectors:
        """Log odds of the options; the odds of an option's labels are added up.

        Args:
            question: has ``things``. An option without labels is its own label.

        Returns:
            (n,) float64.
        """
        named = [option.labels or (phrase(option.name),) for option in question.options]
        labels = tuple(dict.fromkeys(label for names in named for label in names))
        reading = self._reading(labels, question.habits, question.weights)
        by_label = dict(zip(labels, reading.logits(question.things).tolist(), strict=True))
        return np.array([np.logaddexp.reduce([by_label[label] for label in dict.fromkeys(names)]) for names in named])

    def _reading(self, labels: tuple[str, ...], habits: tuple[str, ...], counts: tuple[float, ...]) -> _Reading:
        key = (labels, habits, counts)
        if key in self._readings:
            self._readings.move_to_end(key)
            return self._readings[key]
        if self._furniture is None:
            self._furniture = self._encode(furniture_names())
        reading = self._readings[key] = _Reading(labels, habits, self._furniture, self._encode, self._weights, counts)
        if len(self._readings) > _EPISODES:
            self._readings.popitem(last=False)
        return reading


class _Reading:
    """Terms of some labels and habits: those independent of the place, and a column for each thing seen so far."""

    def __init__(
        self,
        labels: tuple[str, ...],
        habits: tuple[str, ...],
        furniture: Vectors,
        encode: Callable[[Sequence[str]], Vectors],
        weights: LocationWeights,
        counts: tuple[float, ...] = (),
    ) -> None:
        """``furniture`` (F, D); there may be no habits. ``counts`` (H,): how much each counts, or ()."""
        self._encode, self._w = encode, weights
        self._labels, self._habits = encode(labels), encode(habits)  # (L, D), (H, D)
        near = self._labels @ furniture.T  # (L, F)
        self._usual_like = near.mean(1)  # (L,)
        about = self._labels @ self._habits.T / weights.about  # (L, H)
        top = np.maximum(about.max(0), weights.named / weights.about)
        odds = np.exp(about - top)
        share = odds / (odds.sum(0) + np.exp(weights.named / weights.about - top))  # (L, H)
        if counts:
            share = share * np.asarray(counts)
        self._number = share.sum(1)  # (L,)
        fits = np.exp(furniture @ self._habits.T / weights.sigma)  # (F, H)
        self._share = share / (np.exp(-weights.other * near / weights.sigma) @ fits / len(furniture))  # (L, H)
        self._columns: dict[str, Vectors] = {}

    def logits(self, things: Sequence[str]) -> Vectors:
        """Log odds (L,) of the labels where these things stand."""
        w = self._w
        like, said = np.mean([self._column(thing) for thing in dict.fromkeys(things)], axis=0)
        if not len(self._habits):
            return np.asarray(w.like * (like - self._usual_like))
        return np.asarray(w.weight * np.log((w.doubt + said) / (w.doubt + self._number)))

    def _column(self, thing: str) -> Vectors:
        """(2, L): likeness of each label to a thing, and how well its habits fit it.

        One thing at a time, so that its bytes do not depend on the others.
        """
        if thing not in self._columns:
            w, vector = self._w, self._encode([thing])[0]
            like = self._labels @ vector
            said = self._share @ np.exp(self._habits @ vector / w.sigma) * np.exp(-w.other * like / w.sigma)
            self._columns[thing] = np.stack([like, said])
        return self._columns[thing]


@cache
def furniture_names() -> tuple[str, ...]:
    """Names, with spaces, of all furniture and fixtures of the catalogue."""
    book = catalogue()
    return tuple(phrase(name) for name in book.names if book[name].role not in ("movable", "structure"))
