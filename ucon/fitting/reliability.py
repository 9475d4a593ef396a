"""Measures whether a detector's fitted errors hold in homes that they were not fitted on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.fitting.detector_errors import fit_errors
from ucon.fitting.detector_looks import FalseBoxes, Looks
from ucon.perception.mapping.detections import MIN_PIXELS

#: One walk in this many is held out.
_FOLDS = 4
#: Number of groups, of equal width in predicted chance.
GROUPS = 10
#: Groups with fewer looks are left out.
LEAST_LOOKS = 20


@dataclass(frozen=True)
class Reliability:
    """Predicted and observed share of things found in held-out walks; a row for each group of looks."""

    predicted: NDArray[np.float64]
    """(g,) mean predicted chance."""
    observed: NDArray[np.float64]
    """(g,) share that was found."""
    looks: NDArray[np.int64]
    """(g,) number of looks."""

    @property
    def error(self) -> float:
        """Expected calibration error."""
        return float((np.abs(self.predicted - self.observed) * self.looks).sum() / self.looks.sum())

    @property
    def text(self) -> str:
        """The rows as a table."""
        lines = [f"found in {self.looks.sum():,} looks of walks held out: predicted, observed (%)"]
        for p, found, n in zip(self.predicted, self.observed, self.looks, strict=True):
            lines.append(f"{100 * p:9.0f}{100 * found:8.0f}{n:12,} looks")
        return "\n".join([*lines, f"expected calibration error {self.error:.3f}"])


def reliability(detector: str, looks: Looks, false: FalseBoxes) -> Reliability:
    """Compare predicted and observed share of things found, in walks that are held out of a second fit.

    Args:
        detector: its name.
        looks: all looks; a quarter of the walks is held out.
        false: boxes on nothing.
    """
    out = (looks.home % _FOLDS == 0) & (looks.name >= 0) & (looks.pixels >= MIN_PIXELS)
    fitted, held = fit_errors(detector, looks.keep(looks.home % _FOLDS != 0), false), looks.keep(out)
    share = np.minimum(held.pixels / np.maximum(held.whole, 1.0), 1.0)
    predicted = fitted.found(held.pixels, held.away_m, share)
    group = np.minimum((predicted * GROUPS).astype(int), GROUPS - 1)
    count, stated, found = (np.bincount(group, w, GROUPS) for w in (None, predicted, held.found))
    some = count >= min(LEAST_LOOKS, len(group))
    return Reliability(stated[some] / count[some], found[some] / count[some], count[some].astype(np.int64))
