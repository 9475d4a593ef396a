"""What the belief head reads: numbers about a household's habits, about candidate anchors, and about targets.

Training and use build them by the same functions. All is open-vocabulary: a candidate that the evidence reader never
met has pair features, a name and no more. Several targets share the habits of one household; a mask says which of them
each target is given, so the habit levels differ by the mask alone.
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

Half = NDArray[np.float32]
N_RELATIONS: Final = len(RELATIONS)
N_PAIR: Final = N_FEATURES + 3
"""Of a (habit, candidate) pair: pair features, and what the evidence reader says: probability, its log, its kind."""
N_HABIT: Final = 1 + N_RELATIONS
"""Of a habit: does it speak for a place, and in which relation."""
N_RELEVANCE: Final = N_GATE + 1
"""Of a (target, habit) pair: features of the fitted gate, and its logit."""
N_CANDIDATE: Final = 2
"""Of a candidate: does the evidence reader know it, does the prior."""
SMALL: Final = 1e-3


@dataclass(frozen=True, eq=False)
class HeadInputs:
    """T targets of one household with H habits and C candidates. float32 but for the masks; vectors are (., 384)."""

    sentence: Half  # (H, D) vectors of the habits
    habit: Half  # (H, N_HABIT)
    pair: Half  # (H, C, N_PAIR)
    name: Half  # (C, D) vectors of the candidates' names
    candidate: Half  # (C, N_CANDIDATE)
    relation_prior: Half  # (C, 4) what is usual; rows add up to 1, impossible relations are 0
    target: Half  # (T, D) vectors of the targets' names
    prior: Half  # (T, C) log p(anchor | target) of common sense
    relevance: Half  # (T, H, N_RELEVANCE)
    given: NDArray[np.bool_]  # (T, H) the habits that are read for each target
    trusted: NDArray[np.bool_]  # (T,) all that is given is about the target (level gt)
    open: NDArray[np.bool_]  # (T, C) candidates of each target; the target itself is none


def pair_columns(features: NDArray[np.floating], said: Array, known: NDArray[np.bool_]) -> Half:
    """Pair inputs (H, C, N_PAIR) of pair features (H, C, 6) and what the evidence reader says (H, C).

    ``known`` (C,): names that the evidence reader was fitted on; of the others it read the pair features alone.
    """
    h, c = said.shape
    out = np.empty((h, c, N_PAIR), np.float32)
    out[:, :, :N_FEATURES] = features
    out[:, :, N_FEATURES] = said
    out[:, :, N_FEATURES + 1] = np.log(said + SMALL)
    out[:, :, N_FEATURES + 2] = known
    return out


def unknown_said(features: NDArray[np.floating], any_weights: Array, place: Array) -> Array:
    """(H, C): what the evidence reader says of names that it never met, from pair features (H, C, 6)."""
    return sigmoid(features.astype(np.float64) @ any_weights[:-1] + any_weights[-1]) * place[:, None]


def habit_columns(evidence: Evidence) -> Half:
    """Habit inputs (H, N_HABIT) of what the evidence reader says."""
    return np.concatenate([evidence.place[:, None], evidence.relation], axis=1).astype(np.float32)
