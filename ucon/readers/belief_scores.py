"""Scores of a belief against the true distribution over placements: exact expectations, no sampling."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
FIGURES: Final = ("hit_at_1", "hit_at_5", "nll", "visits", "relation")
#: Number of best candidates per belief that enter the calibration error, and its number of bins.
TOP, BINS = 20, 15


def scores(p: Array, relation: Array, y: Array) -> dict[str, float]:
    """Scores of one belief.

    ``hit_at_k`` is the true probability of the k best candidates, ``nll`` in nats, ``visits`` the expected number of
    anchors searched in order of belief, ``relation`` the true probability of the most likely relation at each true
    anchor.

    Args:
        p: (C,) belief.
        relation: (C, 4) p(relation | anchor).
        y: (C, 4) true joint distribution.
    """
    by_anchor = y.sum(1)
    found = by_anchor[np.argsort(-p, kind="stable")]
    return {
        "hit_at_1": float(found[:1].sum()),
        "hit_at_5": float(found[:5].sum()),
        "nll": float(-(by_anchor * np.log(np.maximum(p, 1e-12))).sum()),
        "visits": float((found * np.arange(1, len(p) + 1)).sum()),
        "relation": float(np.take_along_axis(y, relation.argmax(1)[:, None], 1).sum()),
    }


def best_of(p: Array, y: Array) -> tuple[Array, Array]:
    """Stated and true probabilities of a belief's 20 best candidates, (20,) each."""
    top = np.argsort(-p, kind="stable")[:TOP]
    return p[top], y[top]


def calibration_error(p: Array, y: Array) -> float:
    """Expected calibration error: mean absolute difference of stated and true probability over 15 bins of equal width.

    Args:
        p: (N,) stated probabilities.
        y: (N,) true probabilities.
    """
    number = np.minimum((p * BINS).astype(int), BINS - 1)
    stated, true = np.bincount(number, p, BINS), np.bincount(number, y, BINS)
    return float(np.abs(stated - true).sum() / max(len(p), 1))
