"""Whether a detector's fitted errors hold in homes that they were not fitted on."""

from __future__ import annotations

import numpy as np

from ucon.fitting.detector_errors import fit_errors
from ucon.fitting.detector_looks import FalseBoxes, Looks
from ucon.perception.mapping.detections import MIN_PIXELS

#: Every so many walks one is held out.
_FOLDS = 4


def reliability(detector: str, looks: Looks, false: FalseBoxes) -> str:
    """Table of the predicted and the observed share of things found, in walks that are held out.

    Args:
        detector: its name.
        looks: all looks; a quarter of the walks is held out of a second fit.
        false: boxes on nothing.

    Returns:
        Five rows by predicted chance, and the expected calibration error.
    """
    out = (looks.home % _FOLDS == 0) & (looks.name >= 0) & (looks.pixels >= MIN_PIXELS)
    fitted, held = fit_errors(detector, looks.keep(looks.home % _FOLDS != 0), false), looks.keep(out)
    share = np.minimum(held.pixels / np.maximum(held.whole, 1.0), 1.0)
    predicted = fitted.found(held.pixels, held.away_m, share)
    group = np.minimum((predicted * 5).astype(int), 4)
    lines, error = [f"found in {len(held.name):,} looks of walks held out: predicted, observed (%)"], 0.0
    for k in range(5):
        rows = group == k
        if rows.any():
            a, b = float(predicted[rows].mean()), float(held.found[rows].mean())
            error += rows.mean() * abs(a - b)
            lines.append(f"{100 * a:9.0f}{100 * b:8.0f}{int(rows.sum()):12,} looks")
    return "\n".join([*lines, f"expected calibration error {error:.3f}"])
