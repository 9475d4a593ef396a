"""Agreement between raters: Krippendorff's alpha with its bootstrap interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ucon.core.rng import stream
from ucon.evaluation.figures.intervals import Interval

Scale = Literal["nominal", "ordinal"]
_RESAMPLES = 2_000


def krippendorff_alpha(ratings: Sequence[Sequence[int]], categories: int, scale: Scale) -> float | None:
    """Krippendorff's alpha: 1 for perfect agreement, 0 for agreement by chance.

    Args:
        ratings: the ratings of each item, whole numbers from 0 to ``categories`` - 1; items with fewer than two ratings
            are left out.
        categories: number of possible values.
        scale: ``nominal`` counts any two values as equally different, ``ordinal`` by their rank.

    Returns:
        None where it is undefined: no item has two ratings, or all ratings are equal.
    """
    return _alpha(_coincidences(ratings, categories).sum(0), scale)


def alpha_interval(
    ratings: Sequence[Sequence[int]], categories: int, scale: Scale, *, seed: int = 0
) -> Interval | None:
    """Alpha with the percentile interval of 2,000 bootstrap samples of items.

    Args:
        ratings: as for :func:`krippendorff_alpha`.
        categories: number of possible values.
        scale: ``nominal`` or ``ordinal``.
        seed: of the samples.

    Returns:
        None where alpha is undefined.
    """
    units = _coincidences(ratings, categories)
    mean = _alpha(units.sum(0), scale)
    if mean is None:
        return None
    rng = stream(seed, "bootstrap", "alpha", len(units))
    drawn = (_alpha(units[rng.integers(len(units), size=len(units))].sum(0), scale) for _ in range(_RESAMPLES))
    low, high = np.quantile([value for value in drawn if value is not None], (0.025, 0.975))
    return Interval(mean, float(low), float(high), len(units))


def to_json(interval: Interval | None) -> Mapping[str, float | int] | None:
    """Mean, low, high and n of an interval, rounded to four digits; None for None."""
    if interval is None:
        return None
    mean, low, high = (round(value, 4) for value in (interval.mean, interval.low, interval.high))
    return {"mean": mean, "low": low, "high": high, "n": interval.n}


def _coincidences(ratings: Sequence[Sequence[int]], categories: int) -> NDArray[np.float64]:
    """Coincidence matrix of every item with two or more ratings, (n, categories, categories)."""
    found = [np.zeros((0, categories, categories))]
    for values in ratings:
        if len(values) > 1:
            counts = np.bincount(np.asarray(values), minlength=categories).astype(float)
            found.append((np.outer(counts, counts) - np.diag(counts))[None] / (len(values) - 1))
    return np.concatenate(found)


def _alpha(observed: NDArray[np.float64], scale: Scale) -> float | None:
    """Alpha of a coincidence matrix."""
    margins = observed.sum(0)
    n = margins.sum()
    difference = _difference(margins, scale)
    expected = (np.outer(margins, margins) * difference).sum() / max(n - 1, 1.0)
    return float(1 - (observed * difference).sum() / expected) if expected > 0 else None


def _difference(margins: NDArray[np.float64], scale: Scale) -> NDArray[np.float64]:
    """Squared differences between values, (categories, categories)."""
    if scale == "nominal":
        return 1.0 - np.eye(len(margins))
    rank = margins.cumsum() - margins / 2  # mean rank of each value among all ratings
    squared: NDArray[np.float64] = (rank[:, None] - rank[None, :]) ** 2
    return squared
