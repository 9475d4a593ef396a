"""The fitted anchor reader: a distribution over the target's anchors, from a prior and from what the habits say.

Three small fitted parts: a prior p(anchor | target) from the target's name, the evidence of each habit for each anchor,
and a relevance gate. They were fitted on the habit book's train categories; the few weights that mix them, on its val
categories. Names outside the training data are read by pair features alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ucon.core.sharing import Shared, is_the_one
from ucon.habits.contexts import Context
from ucon.language.pairs import PairReader, default_pair_reader
from ucon.language.phrases import phrase
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_prior import UNKNOWN_PRIOR
from ucon.readers.conditions.condition_reader import ConditionReader, default_conditions
from ucon.readers.evidence import SUPPORT_FLOOR, Evidence, EvidenceReader
from ucon.readers.gate import relevance
from ucon.readers.reader_weights import Array, ReaderWeights, default_weights, softmax, two_layers

RELATION_PRIOR = 0.5
N_MIX = 6


@dataclass(frozen=True, eq=False)
class AnchorBelief:
    """Distribution over the target's anchors; ``p`` and ``unseen`` add up to 1."""

    candidates: tuple[str, ...]
    """The C candidate categories."""
    p: Array
    """(C,) probability that the target is placed at an anchor of each category."""
    relation: Array
    """(C, 4) p(relation | anchor), in the order of ``RELATIONS``; rows add up to 1."""
    unseen: float
    """Probability of the known anchor categories that are no candidates."""
    unseen_p: dict[str, float]
    """That probability by category."""


class Reading(Shared):
    """What H habits say about one target. Candidates may be added while a home is explored.

    Args:
        reader: has the fitted parts.
        target: category that is looked for.
        texts: the habits.
        trusted: True if all habits are about the target (level ``gt``).
    """

    def __init__(self, reader: AnchorReader, target: str, texts: tuple[str, ...], trusted: bool) -> None:
        self.target = target
        self.texts = texts
        self._reader = reader
        self._evidence: Evidence = reader.evidence.read(texts)
        gate = np.ones(len(texts)) if trusted else relevance(target, texts, reader.pairs, reader.weights)
        self._gate: Array = gate
        self._told: _Told | None = None
        self.relevance: Array = gate
        """(H,) probability that each habit is about the target; 1 if trusted. Lower where a habit does not hold in the
        told context."""
        self.telling: Array = gate * self._evidence.place
        """(H,) how much each habit says where the target is: relevance times probability of speaking for a place."""
        self.context = (float(trusted and len(texts) > 0), float(np.log1p((gate * self._evidence.place).sum())))
        self.known_features = reader.mix_features(
            reader.prior(target), gate[:, None] * self._evidence.anchor, np.ones(len(reader.known)), self.context
        )
        self._columns: dict[str, Array] = {}
        self._x: dict[str, Array] = {}

    def weighed(self, holds: Array, sharpness: float) -> Reading:
        """The same reading in a told context.

        Args:
            holds: (H,) how much each habit counts.
            sharpness: power to which the resulting change is raised.
        """
        other = object.__new__(Reading)
        other.__dict__.update(self.__dict__)
        other._told = _Told(self._gate, holds, sharpness)
        other.relevance = np.minimum(self._gate * holds, 1.0)
        other.telling = other.relevance * self._evidence.place
        return other

    def belief(self, candidates: Sequence[str]) -> AnchorBelief:
        """Distribution over candidate anchor categories; the target itself gets 0.

        Args:
            candidates: category names; duplicates count once.
        """
        names = tuple(dict.fromkeys(candidates))
        self._read_unknown([name for name in names if name not in self._reader.number])
        number = self._reader.number
        x = [self.known_features[number[name]] if name in number else self._x[name] for name in names]
        hidden = [name for name in self._reader.known if name not in set(names)]
        x += [self.known_features[number[name]] for name in hidden]
        logits = self._reader.mix(np.stack(x))
        if self._told is not None:
            logits += self._told.change(np.stack([self._column(name) for name in (*names, *hidden)], axis=1))
        logits[[i for i, name in enumerate((*names, *hidden)) if name == self.target]] = -60.0
        p = softmax(logits)
        unseen = {name: float(value) for name, value in zip(hidden, p[len(names) :], strict=True)}
        return AnchorBelief(names, p[: len(names)], self._relations(names), float(sum(unseen.values())), unseen)

    def support(self, anchor: str) -> Array:
        """(H,) how strongly each habit speaks for the target being at ``anchor``: the reasons for a belief."""
        return self.relevance * self._column(anchor)

    def _column(self, anchor: str) -> Array:
        if anchor in self._reader.number:
            return self._evidence.anchor[:, self._reader.number[anchor]]
        self._read_unknown([anchor])
        return self._columns[anchor]

    def unknown_features(self, names: Sequence[str]) -> Array:
        """Inputs (n, 6) of the mixing weights for names outside the training data."""
        self._read_unknown(names)
        return np.stack([self._x[name] for name in names]) if names else np.zeros((0, N_MIX))

    def _read_unknown(self, names: Sequence[str]) -> None:
        new = [name for name in dict.fromkeys(names) if name not in self._columns]
        if not new:
            return
        said = self._reader.evidence.unknown(self.texts, new, self._evidence.place)
        prior = np.full(len(new), UNKNOWN_PRIOR)
        x = self._reader.mix_features(prior, self._gate[:, None] * said, np.zeros(len(new)), self.context)
        for i, name in enumerate(new):
            self._columns[name] = said[:, i]
            self._x[name] = x[i]

    def _relations(self, names: Sequence[str]) -> Array:
        """p(relation | anchor), (C, 4): the prior plus what the habits that speak for the anchor say."""
        if not names:
            return np.zeros((0, len(RELATIONS)))
        prior = np.stack([self._reader.relation_prior(name) for name in names])
        speaks = (
            np.stack([self._column(name) for name in names], axis=1)
            * (self._gate if self._told is None else self._told.gate)[:, None]
        )
        total = RELATION_PRIOR * prior + (speaks.T @ self._evidence.relation) * (prior > 0)
        return total / total.sum(axis=1, keepdims=True)


class _Told(Shared):
    """The effect of a told context, added to the logits, since mixing was fitted on habits that all count alike."""

    def __init__(self, plain: Array, holds: Array, sharpness: float) -> None:
        """``plain`` (H,): relevance of the habits; ``holds`` (H,): how much each counts."""
        self.plain, self.gate, self._sharpness = plain, plain * holds, sharpness

    def change(self, said: Array) -> Array:
        """(C,) added to the logits of C candidates; ``said`` (H, C) is the habits' evidence for them."""
        before, now = (np.log(SUPPORT_FLOOR + gate @ said) for gate in (self.plain, self.gate))
        return self._sharpness * (now - before)


class AnchorReader(Shared):
    """Reads habits with the fitted parts. One per process; it caches evidence by text.

    Args:
        weights: of the fitted parts; the shipped ones by default.
        pairs: encodes sentences and pairs; the default one if not given.
        conditions: reads which sentences hold in a told context; the shipped one, loaded at first use.
    """

    def __init__(
        self,
        weights: ReaderWeights | None = None,
        pairs: PairReader | None = None,
        conditions: ConditionReader | None = None,
    ) -> None:
        self.weights = weights or default_weights()
        self.pairs = pairs or default_pair_reader()
        self.evidence = EvidenceReader(self.weights, self.pairs)
        self.known = self.weights.anchors
        self.number = {name: i for i, name in enumerate(self.known)}
        self._conditions = conditions

    @property
    def conditions(self) -> ConditionReader:
        """Reads which sentences hold in a told context."""
        return self._conditions or default_conditions()

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickle the shipped reader by name; its weights are checked wherever they are loaded."""
        return (default_reader, ()) if is_the_one(default_reader, self) else super().__reduce_ex__(protocol)

    def read(
        self, target: str, texts: Sequence[str], *, trusted: bool = False, context: Context | None = None
    ) -> Reading:
        """Read habits once for an episode.

        Args:
            target: category that is looked for.
            texts: the habits that an agent is given.
            trusted: True if all of them are about the target (habit level ``gt``): they are not gated.
            context: the context that was told: habits that do not hold in it count less, those that do count more.
        """
        plain = Reading(self, target, tuple(texts), trusted)
        if context is None:
            return plain
        holds, strength = self.conditions.weights(texts, context, "fitted"), self.conditions.strengths["fitted"]
        return plain.weighed(holds, strength.sharpness)

    def belief(
        self, target: str, texts: Sequence[str], candidates: Sequence[str], *, trusted: bool = False
    ) -> AnchorBelief:
        """:meth:`read` and :meth:`Reading.belief` in one call.

        Args:
            target: category that is looked for.
            texts: the habits.
            candidates: anchor categories.
            trusted: True if all habits are about the target.
        """
        return self.read(target, texts, trusted=trusted).belief(candidates)

    def prior(self, target: str) -> Array:
        """Log p(anchor | target) over the A known anchors, (A,), before any habit is read."""
        name = self.pairs.encoder.encode_half([phrase(target)])[0].astype(np.float64)
        logits = np.round(name @ self.weights["prior_dense"] + self.weights["prior_bias"], 4)
        return np.log(softmax(logits))

    def relation_prior(self, anchor: str) -> Array:
        """p(relation | anchor), (4,), before any habit is read; uniform for an unknown anchor."""
        table = self.weights["relation_prior"]
        return table[self.number[anchor]] if anchor in self.number else np.full(len(RELATIONS), 1 / len(RELATIONS))

    def mix_features(self, prior: Array, gated: Array, known: Array, context: tuple[float, float]) -> Array:
        """Inputs of :meth:`mix` for C candidates.

        Args:
            prior: (C,) log-probabilities.
            gated: (H, C) evidence times relevance.
            known: (C,) 1 for anchors in the training data, else 0.
            context: whether the habits are trusted, and log of how much they say.

        Returns:
            (C, 6): prior, log of sum and of maximum of the evidence, known, and the two of ``context``.
        """
        total = np.log(SUPPORT_FLOOR + gated.sum(axis=0))
        best = np.log(SUPPORT_FLOOR + gated.max(axis=0, initial=0.0))
        columns = [prior, total, best, known, np.full(len(known), context[0]), np.full(len(known), context[1])]
        return np.stack(columns, axis=1)

    def mix(self, x: Array) -> Array:
        """Logits (C,) of candidates from inputs (C, 6) of :meth:`mix_features`."""
        w = self.weights
        return two_layers(x, w["mix_hidden"], w["mix_hidden_bias"], w["mix_out"])


@cache
def default_reader() -> AnchorReader:
    """The shipped reader, one per process."""
    return AnchorReader()
