"""The relevance gate: the probability that a sentence is about the target and not about something else in the home.

Its inputs are the words and vectors of both texts, and how a habit compares with the others: its cosine relative to the
set, and its likeness to the habits nearest to the target.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ucon.language.pairs import PairReader
from ucon.language.phrases import phrase, query_text
from ucon.readers.reader_weights import Array, ReaderWeights, sigmoid, two_layers

NEAREST = 5
N_GATE = 10
"""Features of a (target, habit) pair: the 9 of :func:`gate_features` and the learned likeness."""
DECIMALS = 4


def gate_features(target: str, texts: Sequence[str], pairs: PairReader) -> tuple[Array, Array]:
    """Inputs of the gate for H habits, without the learned likeness.

    Args:
        target: category that is looked for.
        texts: the habits.
        pairs: encodes sentences and pairs.

    Returns:
        Features (H, 9) and sentence vectors (H, D), float64.
    """
    vectors = pairs.encoder.encode_half(texts).astype(np.float64)
    query = pairs.encoder.encode_half([query_text(target)])[0].astype(np.float64)
    lexical = pairs.features(texts, [target])[:, 0].astype(np.float64)
    return set_features(lexical, np.round(vectors @ query, DECIMALS), vectors), vectors


def set_features(lexical: Array, cosine: Array, vectors: Array) -> Array:
    """Features (H, 9) of habits within their set.

    Args:
        lexical: (H, 6) pair features of habit and target.
        cosine: (H,) with the retrieval query.
        vectors: (H, D) of the habits.
    """
    relative = (cosine - cosine.mean()) / (cosine.std() + 1e-6) / 3
    top = np.argsort(-cosine, kind="stable")[:NEAREST]
    like = np.round(vectors @ vectors[top].T, DECIMALS)
    like[top, np.arange(len(top))] = 0
    others = len(top) - np.isin(np.arange(len(cosine)), top)
    columns = [lexical, cosine[:, None], relative[:, None], (like.sum(axis=1) / np.maximum(others, 1))[:, None]]
    return np.concatenate(columns, axis=1)


def relevance(target: str, texts: Sequence[str], pairs: PairReader, weights: ReaderWeights) -> Array:
    """Probability (H,) that each habit, if it speaks for a place, speaks for a place of the target.

    Args:
        target: category that is looked for.
        texts: the habits.
        pairs: encodes sentences and pairs.
        weights: of the gate.
    """
    if not texts:
        return np.zeros(0)
    features, vectors = gate_features(target, texts, pairs)
    name = pairs.encoder.encode_half([phrase(target)])[0].astype(np.float64)
    return sigmoid(gate_inputs(features, vectors, name, weights)[:, -1])


def gate_inputs(features: Array, vectors: Array, name: Array, weights: ReaderWeights) -> Array:
    """Features (H, 9), learned likeness, and the logit of relevance, in one array.

    Args:
        features: (H, 9) of :func:`gate_features`.
        vectors: (H, D) of the habits.
        name: (D,) of the target's name.
        weights: of the gate.

    Returns:
        (H, 11) float64.
    """
    likeness = np.round((vectors @ weights["gate_habit"]) @ (name @ weights["gate_target"]), DECIMALS)
    x = np.concatenate([features, likeness[:, None]], axis=1)
    logit = two_layers(x, weights["gate_hidden"], weights["gate_hidden_bias"], weights["gate_out"])
    return np.concatenate([x, logit[:, None]], axis=1)
