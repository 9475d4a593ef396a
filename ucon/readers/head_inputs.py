"""Inputs of the belief head: features of a household's habits, of candidate anchors, of targets, and of their pairs.

Training and use build them with the same functions. The vocabulary is open: a candidate outside the evidence reader's
training data has pair features and a name vector only. Several targets share the habits of a household; a mask says
which habits each target is given, so habit levels differ only by the mask.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.language.pairs import N_FEATURES
from ucon.objects.model import RELATIONS
from ucon.readers.evidence import Evidence
from ucon.readers.gate import N_GATE
from ucon.readers.reader_weights import Array, sigmoid

Float32 = NDArray[np.float32]
N_RELATIONS: Final = len(RELATIONS)
N_PAIR: Final = N_FEATURES + 3
"""Features of a (habit, candidate) pair: pair features; evidence, its log, and whether the candidate is known."""
N_HABIT: Final = 1 + N_RELATIONS
"""Features of a habit: probability that it speaks for a place, and its distribution over relations."""
N_RELEVANCE: Final = N_GATE + 1
"""Features of a (target, habit) pair: inputs of the fitted gate, and its logit."""
N_CANDIDATE: Final = 2
"""Features of a candidate: whether the evidence reader knows it, and whether the prior does."""
SMALL: Final = 1e-3


@dataclass(frozen=True, eq=False)
class HeadInputs:
    """Arrays for T targets of one household with H habits and C candidates.

    Float32 except the masks, vectors of D = 384.
    """

    sentence: Float32
    """(H, D) vectors of the habits."""
    habit: Float32
    """(H, N_HABIT) features."""
    pair: Float32
    """(H, C, N_PAIR) features."""
    name: Float32
    """(C, D) vectors of the candidates' names."""
    candidate: Float32
    """(C, N_CANDIDATE) features."""
    relation_prior: Float32
    """(C, 4) p(relation | anchor) before reading; rows add up to 1, impossible relations are 0."""
    target: Float32
    """(T, D) vectors of the targets' names."""
    prior: Float32
    """(T, C) log p(anchor | target) before reading."""
    relevance: Float32
    """(T, H, N_RELEVANCE) features."""
    given: NDArray[np.bool_]
    """(T, H) True for habits that are given for the target."""
    trusted: NDArray[np.bool_]
    """(T,) True if all given habits are about the target (level gt)."""
    open: NDArray[np.bool_]
    """(T, C) True for candidates that may be the anchor; the target itself may not."""
    holds: Float32 | None = None
    """(T, H) how much each habit counts in the told context (:mod:`ucon.readers.conditions`); None: none was told."""


def pair_columns(features: NDArray[np.floating], said: Array, known: NDArray[np.bool_]) -> Float32:
    """Features of (habit, candidate) pairs.

    Args:
        features: (H, C, 6) pair features.
        said: (H, C) evidence of each habit for each candidate.
        known: (C,) bool, True for names that the evidence reader was fitted on.

    Returns:
        (H, C, N_PAIR) float32.
    """
    h, c = said.shape
    out = np.empty((h, c, N_PAIR), np.float32)
    out[:, :, :N_FEATURES] = features
    out[:, :, N_FEATURES] = said
    out[:, :, N_FEATURES + 1] = np.log(said + SMALL)
    out[:, :, N_FEATURES + 2] = known
    return out


def unknown_said(features: NDArray[np.floating], any_weights: Array, place: Array) -> Array:
    """Evidence (H, C) for names outside the evidence reader's training data.

    Args:
        features: (H, C, 6) pair features.
        any_weights: (7,) weights and bias.
        place: (H,) probability that each habit speaks for any place.
    """
    return sigmoid(features.astype(np.float64) @ any_weights[:-1] + any_weights[-1]) * place[:, None]


def habit_columns(evidence: Evidence) -> Float32:
    """Features (H, N_HABIT) of habits from their evidence, float32."""
    return np.concatenate([evidence.place[:, None], evidence.relation], axis=1).astype(np.float32)
