"""The relevance gate: is this sentence about the target, or about something else in the home?

Beyond the words and vectors of the two texts it sees how a habit stands among the others: its cosine relative to
the set, and its likeness to the habits nearest to the target.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ucon.language.pairs import PairReader
from ucon.retrieval.base import phrase, query_text
from ucon.retrieval.weights import Array, Weights, sigmoid, two_layers

NEAREST = 5
N_GATE = 10
"""Features of a habit: those of :func:`gate_features` and the learned likeness."""
DECIMALS = 4


def gate_features(target: str, texts: Sequence[str], pairs: PairReader) -> tuple[Array, Array]:
    """Features (H, 9) of each habit for a target, without the learned likeness, and sentence vectors (H, dim)."""
    vectors = pairs.encoder.encode_half(texts).astype(np.float64)
    query = pairs.encoder.encode_half([query_text(target)])[0].astype(np.float64)
    cosine = np.round(vectors @ query, DECIMALS)
    relative = (cosine - cosine.mean()) / (cosine.std() + 1e-6) / 3
    top = np.argsort(-cosine, kind="stable")[:NEAREST]
    like = np.round(vectors @ vectors[top].T, DECIMALS)
    like[top, np.arange(len(top))] = 0
    others = len(top) - np.isin(np.arange(len(texts)), top)
    lexical = pairs.features(texts, [target])[:, 0].astype(np.float64)
    columns = [lexical, cosine[:, None], relative[:, None], (like.sum(axis=1) / np.maximum(others, 1))[:, None]]
    return np.concatenate(columns, axis=1), vectors


def relevance(target: str, texts: Sequence[str], pairs: PairReader, weights: Weights) -> Array:
    """Probability (H,) that each habit, if it speaks for a place, speaks for a place of the target."""
    if not texts:
        return np.zeros(0)
    features, vectors = gate_features(target, texts, pairs)
    name = pairs.encoder.encode_half([phrase(target)])[0].astype(np.float64)
    likeness = np.round((vectors @ weights["gate_habit"]) @ (name @ weights["gate_target"]), DECIMALS)
    x = np.concatenate([features, likeness[:, None]], axis=1)
    return sigmoid(two_layers(x, weights["gate_hidden"], weights["gate_hidden_bias"], weights["gate_out"]))
