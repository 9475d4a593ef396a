"""Figures of a belief against the distribution that placements are drawn from: exact expectations, no drawn place."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
FIGURES: Final = ("hit_at_1", "hit_at_5", "nll", "visits", "relation")
#: Of each belief so many of the best candidates are looked at for the calibration error, in so many bins.
TOP, BINS = 20, 15


def scores(p: Array, relation: Array, y: Array) -> dict[str, float]:
    """Figures of a belief ``p`` (C,) with relations (C, 4) against the true joint distribution ``y`` (C, 4).

    ``hit_at_k``: true mass of the k best; ``visits``: expected number of anchors looked at, in order; ``relation``:
    true mass of the likeliest relation of each true anchor.
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
    """Stated and true probability of the best candidates of a belief, (TOP,) each."""
    top = np.argsort(-p, kind="stable")[:TOP]
    return p[top], y[top]


def calibration_error(p: Array, y: Array) -> float:
    """What is stated against what is true, over equally wide bins of what is stated."""
    number = np.minimum((p * BINS).astype(int), BINS - 1)
    stated, true = np.bincount(number, p, BINS), np.bincount(number, y, BINS)
    return float(np.abs(stated - true).sum() / max(len(p), 1))
