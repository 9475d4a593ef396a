"""Evidence of one sentence: which anchor it speaks for, if any, and with which relation.

Cached by text. Known anchors are read from words, sentence vector and pair features together; names outside the
training data, from pair features alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from ucon.language.pairs import PairReader
from ucon.language.words import stems
from ucon.readers.reader_weights import Array, ReaderWeights, sigmoid, softmax

REMEMBERED = 60_000
DECIMALS = 4

#: Added to evidence before its logarithm is taken.
SUPPORT_FLOOR: Final = 0.02


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence of H sentences for A known anchors; float64."""

    anchor: Array
    """(H, A) probability that the sentence speaks for each anchor; the rest to 1 is "no place"."""
    place: Array
    """(H,) probability that the sentence speaks for any place."""
    relation: Array
    """(H, 4) relation, given that it does, in the order of ``RELATIONS``."""


def grams(text: str) -> list[str]:
    """Distinct stems and pairs of adjacent stems of a text, in order."""
    words = stems(text)
    return list(dict.fromkeys([*words, *(f"{a} {b}" for a, b in pairwise(words))]))


class EvidenceReader:
    """Applies the fitted weights to texts.

    Args:
        weights: of the evidence reader.
        pairs: encodes sentences and pairs.
    """

    def __init__(self, weights: ReaderWeights, pairs: PairReader) -> None:
        self.weights = weights
        self.pairs = pairs
        self._seen: dict[str, Array] = {}

    def read(self, texts: Sequence[str]) -> Evidence:
        """Evidence of H texts; each is computed once and cached."""
        new = [text for text in dict.fromkeys(texts) if text not in self._seen]
        if len(self._seen) + len(new) > REMEMBERED:
            self._seen.clear()
            new = list(dict.fromkeys(texts))
        if new:
            self._seen.update(zip(new, self._logits(new), strict=True))
        n = len(self.weights.anchors)
        logits = np.stack([self._seen[text] for text in texts]) if texts else np.zeros((0, n + 5))
        spoken = softmax(logits[:, : n + 1])
        return Evidence(spoken[:, :n], 1 - spoken[:, n], softmax(logits[:, n + 1 :]))

    def unknown(self, texts: Sequence[str], names: Sequence[str], place: Array) -> Array:
        """Evidence for names outside the training data.

        Args:
            texts: H sentences.
            names: C names.
            place: (H,) probability that each sentence speaks for any place.

        Returns:
            (H, C) probabilities.
        """
        score = self.pairs.features(texts, names).astype(np.float64) @ self.weights["any"][:-1]
        return sigmoid(score + self.weights["any"][-1]) * place[:, None]

    def _logits(self, texts: Sequence[str]) -> Array:
        """Logits (n, A + 5): anchors, "no place", and the four relations; rounded to 1e-4."""
        w, n = self.weights, len(self.weights.anchors)
        out = self.pairs.encoder.encode_half(texts).astype(np.float64) @ w["dense"] + w["bias"]
        for i, text in enumerate(texts):
            rows = [w.vocabulary[gram] for gram in grams(text) if gram in w.vocabulary]
            out[i] += w.bow[rows].sum(axis=0, dtype=np.float64)
        out[:, :n] += self.pairs.features(texts, w.anchors).astype(np.float64) @ w["pair"]
        return np.round(out, DECIMALS)
