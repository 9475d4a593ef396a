"""Scores returned rating sheets: means with intervals, agreement of raters, true against swapped places."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ucon.core.rng import stream
from ucon.evaluation.datasets.agreement import alpha_interval, to_json
from ucon.evaluation.datasets.survey import LOOK, RatedHabit, Rating
from ucon.evaluation.figures.intervals import RESAMPLES, Interval, mean_interval, rate_interval


def score_survey(key: Mapping[int, RatedHabit], answers: Sequence[Rating]) -> dict[str, Any]:
    """JSON-ready figures of a survey; None where there are no answers.

    Intervals resample whole items, since ratings of one item are not independent. ``look`` gives the share of "yes" for
    true and for swapped places, and their difference.

    Args:
        key: items by number.
        answers: of all raters.
    """
    rated = [a for a in answers if a.real is not None]
    looked = [a for a in answers if a.look is not None]
    by_truth = {truth: [a for a in looked if key[a.item].truth == truth] for truth in ("true", "swapped")}
    return {
        "raters": len({a.rater for a in answers}),
        "items": len(key),
        "answers_real": len(rated),
        "answers_look": len(looked),
        "real": to_json(
            mean_interval([float(a.real or 0) for a in rated], clusters=[str(a.item) for a in rated]) if rated else None
        ),
        "look": {
            "yes_true": to_json(_yes(by_truth["true"])),
            "yes_swapped": to_json(_yes(by_truth["swapped"])),
            "difference": to_json(_difference(by_truth["true"], by_truth["swapped"])),
            "shares": {truth: _shares(found) for truth, found in by_truth.items()},
        },
        "alpha_real": to_json(alpha_interval(_by_item([(a.item, (a.real or 1) - 1) for a in rated]), 5, "ordinal")),
        "alpha_look": to_json(
            alpha_interval(_by_item([(a.item, LOOK.index(a.look or "no")) for a in looked]), 3, "nominal")
        ),
        "by_rater": {rater: _rater(key, [a for a in answers if a.rater == rater]) for rater in _raters(answers)},
    }


def _raters(answers: Sequence[Rating]) -> list[str]:
    return list(dict.fromkeys(a.rater for a in answers))


def _yes(answers: Sequence[Rating]) -> Interval | None:
    said = [a.look == "yes" for a in answers]
    return rate_interval(said, clusters=[str(a.item) for a in answers]) if said else None


def _shares(answers: Sequence[Rating]) -> dict[str, float] | None:
    if not answers:
        return None
    return {value: round(sum(a.look == value for a in answers) / len(answers), 4) for value in LOOK}


def _difference(true: Sequence[Rating], swapped: Sequence[Rating]) -> Interval | None:
    """Share of "yes" for true minus swapped places.

    The two groups have different items and are resampled separately.
    """
    if not true or not swapped:
        return None
    drawn, means = [], []
    for name, answers in (("true", true), ("swapped", swapped)):
        items = _by_item([(a.item, int(a.look == "yes")) for a in answers])
        sums, counts = np.asarray([sum(i) for i in items]), np.asarray([len(i) for i in items])
        pick = stream(0, "bootstrap", "survey", name).integers(len(items), size=(RESAMPLES, len(items)))
        drawn.append(sums[pick].sum(1) / counts[pick].sum(1))
        means.append(sums.sum() / counts.sum())
    low, high = np.quantile(drawn[0] - drawn[1], (0.025, 0.975))
    return Interval(float(means[0] - means[1]), float(low), float(high), len(true) + len(swapped))


def _by_item(values: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Values grouped by item."""
    found: dict[int, list[int]] = {}
    for item, value in values:
        found.setdefault(item, []).append(value)
    return list(found.values())


def _rater(key: Mapping[int, RatedHabit], answers: Sequence[Rating]) -> dict[str, float | None]:
    def share(truth: str) -> float | None:
        said = [a.look == "yes" for a in answers if a.look and key[a.item].truth == truth]
        return round(float(np.mean(said)), 4) if said else None

    real = [a.real for a in answers if a.real is not None]
    mean = round(float(np.mean(real)), 4) if real else None
    return {"real": mean, "yes_true": share("true"), "yes_swapped": share("swapped")}
