"""From habits to places: belief over the anchors of a target, from common sense and from what the habits say.

Three learned parts, each small: a prior p(anchor | target) from the target's name, evidence of each habit for each
anchor, and a relevance gate. They were fitted on the habit book's training categories, the few weights that mix them
on its validation categories. Names that training never met are read by pair features alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ucon.core.sharing import Shared, is_the_one
from ucon.language.pairs import PairReader, default_pair_reader
from ucon.language.phrases import phrase
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_prior import UNKNOWN_PRIOR
from ucon.readers.evidence import SUPPORT_FLOOR, Evidence, EvidenceReader
from ucon.readers.gate import relevance
from ucon.readers.reader_weights import Array, ReaderWeights, default_weights, softmax, two_layers

RELATION_PRIOR = 0.5
N_MIX = 6


@dataclass(frozen=True, eq=False)
class AnchorBelief:
    """Where the target may be: ``p`` and ``unseen`` add up to 1."""

    candidates: tuple[str, ...]
    p: Array
    """(C,): probability that the target is placed by an anchor of each candidate category."""
    relation: Array
    """(C, 4): relation to it, given that, in the order of ``RELATIONS``; rows add up to 1."""
    unseen: float
    """Mass of known anchor categories that are not among the candidates."""
    unseen_p: dict[str, float]
    """That mass by category."""


class Reading(Shared):
    """What some habits say about one target. Candidates may grow while a home is explored."""

    def __init__(self, reader: AnchorReader, target: str, texts: tuple[str, ...], trusted: bool) -> None:
        self.target = target
        self.texts = texts
        self._reader = reader
        self._evidence: Evidence = reader.evidence.read(texts)
        gate = np.ones(len(texts)) if trusted else relevance(target, texts, reader.pairs, reader.weights)
        self.relevance: Array = gate
        """(H,): how much each habit is taken to be about the target."""
        self.telling: Array = gate * self._evidence.place
        """(H,): how much each habit is taken to say where the target is."""
        self.context = (float(trusted and len(texts) > 0), float(np.log1p((gate * self._evidence.place).sum())))
        self.known_features = reader.mix_features(
            reader.prior(target), gate[:, None] * self._evidence.anchor, np.ones(len(reader.known)), self.context
        )
        self._columns: dict[str, Array] = {}
        self._x: dict[str, Array] = {}

    def belief(self, candidates: Sequence[str]) -> AnchorBelief:
        """Belief over candidate anchor categories (each once; the target itself gets nothing)."""
        names = tuple(dict.fromkeys(candidates))
        self._read_unknown([name for name in names if name not in self._reader.number])
        number = self._reader.number
        x = [self.known_features[number[name]] if name in number else self._x[name] for name in names]
        hidden = [name for name in self._reader.known if name not in set(names)]
        x += [self.known_features[number[name]] for name in hidden]
        logits = self._reader.mix(np.stack(x))
        logits[[i for i, name in enumerate((*names, *hidden)) if name == self.target]] = -60.0
        p = softmax(logits)
        unseen = {name: float(value) for name, value in zip(hidden, p[len(names) :], strict=True)}
        return AnchorBelief(names, p[: len(names)], self._relations(names), float(sum(unseen.values())), unseen)

    def support(self, anchor: str) -> Array:
        """(H,): how strongly each habit speaks for the target being by ``anchor``: the reasons for a belief."""
        return self.relevance * self._column(anchor)

    def _column(self, anchor: str) -> Array:
        if anchor in self._reader.number:
            return self._evidence.anchor[:, self._reader.number[anchor]]
        self._read_unknown([anchor])
        return self._columns[anchor]

    def unknown_features(self, names: Sequence[str]) -> Array:
        """Inputs (n, 6) of the mixing weights for names that training never met."""
        self._read_unknown(names)
        return np.stack([self._x[name] for name in names]) if names else np.zeros((0, N_MIX))

    def _read_unknown(self, names: Sequence[str]) -> None:
        new = [name for name in dict.fromkeys(names) if name not in self._columns]
        if not new:
            return
        said = self._reader.evidence.unknown(self.texts, new, self._evidence.place)
        prior = np.full(len(new), UNKNOWN_PRIOR)
        x = self._reader.mix_features(prior, self.relevance[:, None] * said, np.zeros(len(new)), self.context)
        for i, name in enumerate(new):
            self._columns[name] = said[:, i]
            self._x[name] = x[i]

    def _relations(self, names: Sequence[str]) -> Array:
        """p(relation | anchor) (C, 4): what is usual, and what the habits that speak for the anchor say."""
        if not names:
            return np.zeros((0, len(RELATIONS)))
        prior = np.stack([self._reader.relation_prior(name) for name in names])
        speaks = np.stack([self._column(name) for name in names], axis=1) * self.relevance[:, None]
        total = RELATION_PRIOR * prior + (speaks.T @ self._evidence.relation) * (prior > 0)
        return total / total.sum(axis=1, keepdims=True)


class AnchorReader(Shared):
    """Reads habits. One per process: what it has read it remembers by text."""

    def __init__(self, weights: ReaderWeights | None = None, pairs: PairReader | None = None) -> None:
        self.weights = weights or default_weights()
        self.pairs = pairs or default_pair_reader()
        self.evidence = EvidenceReader(self.weights, self.pairs)
        self.known = self.weights.anchors
        self.number = {name: i for i, name in enumerate(self.known)}

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Pickles name the shipped reader, whose weights are checked wherever they are loaded."""
        return (default_reader, ()) if is_the_one(default_reader, self) else super().__reduce_ex__(protocol)

    def read(self, target: str, texts: Sequence[str], *, trusted: bool = False) -> Reading:
        """Read habits once for an episode.

        Args:
            target: category to be found.
            texts: the habits an agent is given.
            trusted: all of them are about the target (habit level ``gt``), so nothing is gated.
        """
        return Reading(self, target, tuple(texts), trusted)

    def belief(
        self, target: str, texts: Sequence[str], candidates: Sequence[str], *, trusted: bool = False
    ) -> AnchorBelief:
        """:meth:`read` and :meth:`Reading.belief` in one."""
        return self.read(target, texts, trusted=trusted).belief(candidates)

    def prior(self, target: str) -> Array:
        """Common sense: log p(anchor | target) over the known anchors, (A,)."""
        name = self.pairs.encoder.encode_half([phrase(target)])[0].astype(np.float64)
        logits = np.round(name @ self.weights["prior_dense"] + self.weights["prior_bias"], 4)
        return np.log(softmax(logits))

    def relation_prior(self, anchor: str) -> Array:
        """p(relation | anchor), (4,); the mean over anchors for an unknown one."""
        table = self.weights["relation_prior"]
        return table[self.number[anchor]] if anchor in self.number else np.full(len(RELATIONS), 1 / len(RELATIONS))

    def mix_features(self, prior: Array, gated: Array, known: Array, context: tuple[float, float]) -> Array:
        """Inputs (C, 6) of :meth:`mix`: prior, sum and maximum of gated evidence, known, trusted, amount."""
        total = np.log(SUPPORT_FLOOR + gated.sum(axis=0))
        best = np.log(SUPPORT_FLOOR + gated.max(axis=0, initial=0.0))
        columns = [prior, total, best, known, np.full(len(known), context[0]), np.full(len(known), context[1])]
        return np.stack(columns, axis=1)

    def mix(self, x: Array) -> Array:
        """Logits (C,) of candidates."""
        w = self.weights
        return two_layers(x, w["mix_hidden"], w["mix_hidden_bias"], w["mix_out"])


@cache
def default_reader() -> AnchorReader:
    """The shipped reader, one per process."""
    return AnchorReader()
