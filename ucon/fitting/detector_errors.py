"""Fits a detector's errors on training homes: recall, scores, wrong names, false boxes, and which looks err together.

Everything is a maximum likelihood fit of a small model to the looks of :mod:`ucon.fitting.detector_looks`.
"""

from __future__ import annotations

from collections import Counter
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import binary_cross_entropy_with_logits

from ucon.core.errors import DataError
from ucon.fitting.detector_looks import FalseBoxes, Looks
from ucon.perception.detectors.base import vocabulary
from ucon.perception.detectors.confusion import similarity
from ucon.perception.errors.model import DetectorErrors, size_features, vocabulary_hash
from ucon.perception.mapping.detections import MIN_PIXELS

#: Fewest looks that errors can be fitted on.
LEAST_LOOKS: Final = 2000
#: Pixels at which the slope of the recall may change.
_KNOTS_PX: Final = (5.0, 12.0, 60.0, 300.0, 1500.0)
#: Sides and octaves that are tried, the coarsest first, to find which looks err together.
_SIDES, _OCTAVES = (4, 8, 16), (2.0, 1.0, 0.5)


def fit_errors(detector: str, looks: Looks, false: FalseBoxes) -> DetectorErrors:
    """Fit the errors of a detector.

    Args:
        detector: its name.
        looks: at things, from training homes.
        false: boxes on nothing, of the same frames.

    Raises:
        DataError: too few looks, or none of them found anything.
    """
    all_named = looks.keep(looks.name >= 0)
    named = all_named.keep(all_named.pixels >= MIN_PIXELS)
    if len(named.name) < LEAST_LOOKS or named.found.sum() < LEAST_LOOKS // 10:
        raise DataError(
            f"detector={detector}: {len(named.name)} looks at things, {int(named.found.sum())} found; expected "
            f"at least {LEAST_LOOKS} and {LEAST_LOOKS // 10}: walk through more homes (--episodes)"
        )
    knots = tuple(float(x) for x in np.log(_KNOTS_PX))
    share = np.minimum(named.pixels / np.maximum(named.whole, 1.0), 1.0)
    size = size_features(named.pixels, named.away_m, knots)
    recall = logistic(np.column_stack([size, share]), named.found)
    sighted = logistic(size_features(all_named.whole, all_named.away_m, knots), all_named.found)
    hits = named.keep(named.found)
    right = hits.called == hits.name
    score_knots, evidence = _score_evidence(hits.score, right, false.score)
    expected = 1.0 / (1.0 + np.exp(-np.column_stack([size, share]) @ recall))
    sides, octave, within, across = _repeats(named, named.found - expected)
    count = Counter[int]()
    for home in np.unique(named.home):
        rows = named.home == home
        count.update(named.name[rows][np.unique(named.thing[rows], return_index=True)[1]].tolist())
    n_homes, names = len(np.unique(named.home)), vocabulary()
    return DetectorErrors(
        detector=detector,
        vocabulary=vocabulary_hash(),
        looks=len(named.name),
        knots=_rounded(knots),
        recall=_rounded(recall),
        sighted=_rounded(sighted),
        right=round(float(right.mean()), 4),
        score_knots=_rounded(score_knots),
        score_evidence=_rounded(evidence),
        confusion=_rounded(_confusion(hits.name[~right], hits.called[~right])),
        false_boxes=round(len(false.score) / max(false.frames, 1), 4),
        false_share=round(len(false.score) / max(len(false.score) + len(right), 1), 4),
        sides=sides,
        octave=octave,
        repeats=round(within, 3),
        repeats_elsewhere=round(across, 3),
        names=tuple(names[k] for k in sorted(count)),
        counts=_rounded(np.array([count[k] / n_homes for k in sorted(count)])),
    )


def logistic(rows: NDArray[np.float64], truth: NDArray[np.bool_], ridge: float = 1e-4) -> NDArray[np.float64]:
    """Weights (k,) of a logistic regression on rows (n, k)."""
    x, y = torch.from_numpy(rows), torch.from_numpy(truth.astype(np.float64))
    scale = x.abs().max(0).values.clamp_min(1e-9)
    weights = torch.zeros(x.shape[1], dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([weights], max_iter=200, line_search_fn="strong_wolfe")

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        loss = binary_cross_entropy_with_logits((x / scale) @ weights, y) + ridge * weights.square().sum()
        loss.backward()
        return loss

    optimiser.step(closure)
    return np.asarray((weights.detach() / scale).numpy())


def _score_evidence(
    score: NDArray[np.float64], right: NDArray[np.bool_], false: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Log likelihood ratio of right to wrong boxes (wrong names and false boxes), at five scores."""
    every, truth = np.concatenate([score, false]), np.concatenate([right, np.zeros(len(false), bool)])
    knots = np.unique(np.quantile(every, [0.02, 0.25, 0.5, 0.75, 0.98]))
    if truth.all() or len(knots) < 2:
        return knots[[0]], np.zeros(1)
    at = np.stack([np.interp(every, knots, row) for row in np.eye(len(knots))], 1)
    odds = np.log(truth.sum() / max((~truth).sum(), 1))
    return knots, np.clip(logistic(at, truth, 1e-5) - odds, -6.0, 6.0)


def _confusion(true: NDArray[np.int32], called: NDArray[np.int32]) -> NDArray[np.float64]:
    """Weights of the features that make names similar, from pairs of true and wrong name (a conditional logit)."""
    features = torch.from_numpy(similarity())
    weights = torch.zeros(features.shape[2], dtype=torch.float64, requires_grad=True)
    if not len(true):
        return np.zeros(features.shape[2])
    pairs, often = np.unique(np.stack([true, called], 1), axis=0, return_counts=True)
    given, counts = torch.from_numpy(pairs.astype(np.int64)), torch.from_numpy(often)
    rows, inverse = torch.unique(given[:, 0], return_inverse=True)
    few, own = features[rows], torch.zeros(len(rows), features.shape[0], dtype=torch.bool)
    own[torch.arange(len(rows)), rows] = True
    optimiser = torch.optim.LBFGS([weights], max_iter=100, line_search_fn="strong_wolfe")

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        logits = (few @ weights).masked_fill(own, -torch.inf).log_softmax(1)
        loss = -(counts * logits[inverse, given[:, 1]]).sum() / counts.sum() + 1e-4 * weights.square().sum()
        loss.backward()
        return loss

    optimiser.step(closure)
    return weights.detach().numpy()


def look_key(bearing: NDArray[np.float64], away_m: NDArray[np.float64], sides: int, octave: float) -> NDArray[np.int64]:
    """Number of the side and distance that looks are from; looks with the same number err together."""
    side = np.floor(bearing / (2 * np.pi / sides)).astype(np.int64) % sides
    far = np.round(np.log2(np.maximum(away_m, 0.1)) / octave).astype(np.int64)
    return 64 * (far + 16) + side


def _repeats(looks: Looks, residual: NDArray[np.float64]) -> tuple[int, float, float, float]:
    """Sides, octave, and the correlation of residuals of two looks at a thing, within and across sides and distances.

    Takes the coarsest division within which looks err together nearly as much as within the best one.
    """
    thing = looks.home.astype(np.int64) * 100_000 + looks.thing
    whole = _within(thing, residual)
    found = []
    for sides in _SIDES:
        for octave in _OCTAVES:
            group = thing * 4096 + look_key(looks.bearing, looks.away_m, sides, octave)
            within, pairs = _within(group, residual)
            across = (whole[0] * whole[1] - within * pairs) / max(whole[1] - pairs, 1.0)
            found.append((sides, octave, within, across))
    best = max(row[2] for row in found)
    sides, octave, within, across = next(row for row in found if row[2] >= 0.95 * best)
    return sides, octave, float(np.clip(within, 0.0, 1.0)), float(np.clip(across, 0.0, 1.0))


def _within(group: NDArray[np.int64], residual: NDArray[np.float64]) -> tuple[float, float]:
    """Mean product of two residuals of one group over their variance, and the number of such pairs."""
    _, of = np.unique(group, return_inverse=True)
    total, square, n = (np.bincount(of, w) for w in (residual, residual**2, np.ones(len(of))))
    pairs = float((n * (n - 1)).sum())
    return float((total**2 - square).sum()) / max(pairs, 1.0) / max(float(residual.var()), 1e-9), pairs


def _rounded(values: NDArray[np.float64] | tuple[float, ...]) -> tuple[float, ...]:
    return tuple(round(float(x), 4) for x in values)
