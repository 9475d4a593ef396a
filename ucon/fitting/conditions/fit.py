"""Fits probes and softmax regressions of the condition reader on train entries of the habit book.

A probe is more confident on the sentences it was fitted on than on others, so the regressions are fitted with logits of
probes that were not fitted on the sentence's category.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional

from ucon.fitting.conditions.examples import Said, has_conditions, known_occasions, labels, said_in, shown_in
from ucon.habits.splits import Split
from ucon.habits.types import HabitDataset
from ucon.readers.conditions.condition_reader import KINDS, N_FEATURES, USES, ConditionReader, Strength
from ucon.readers.reader_weights import Array, softmax

#: Penalties of the probes' and of the regressions' weights.
PROBE_L2, SHARES_L2 = 1e-4, 1e-5
N_FOLDS: Final = 4
SEED: Final = 1
_EVEN: Final = {use: Strength(1.0, 1.0) for use in USES}


def fit_conditions(dataset: HabitDataset) -> ConditionReader:
    """A condition reader fitted on the dataset's train entries; its strengths are still 1.

    Args:
        dataset: the habits, with contexts.
    """
    said = said_in(dataset, "train")
    occasions, words = known_occasions(dataset)
    reader = ConditionReader(np.zeros((1, len(KINDS))), np.zeros((len(KINDS), N_FEATURES, 3)), occasions, words, _EVEN)
    vectors = reader.sentences([one.text for one in said]).vectors
    has, fold = has_conditions(said), _folds(said)
    mention = np.zeros_like(has)
    for k in range(N_FOLDS):
        others = fit_probe(vectors[fold != k], has[fold != k])
        mention[fold == k] = vectors[fold == k] @ others[:-1] + others[-1]
    x, y = examples(reader, said, mention)
    shares = np.stack([_fit_shares(x[k], y[:, k]) for k in range(len(KINDS))])
    return ConditionReader(fit_probe(vectors, has), shares, occasions, words, _EVEN, reader.encoder)


def examples(reader: ConditionReader, said: Sequence[Said], mention: Array) -> tuple[Array, NDArray[np.int64]]:
    """Features (4, n, N_FEATURES) and labels (n, 4) of sentences in contexts.

    Args:
        reader: has the occasions.
        said: the sentences.
        mention: (len(said), 4) logits of the probes.
    """
    shown = shown_in(said, reader.occasions, SEED)
    read = reader.sentences([one.text for one in said])
    x = np.asarray(
        [
            [reader.features(read.one(k), context, kind, mention[[k], q])[0] for k, context in shown]
            for q, kind in enumerate(KINDS)
        ]
    )
    return x, np.asarray([labels(said[k].condition, context) for k, context in shown])


def measure(reader: ConditionReader, dataset: HabitDataset, part: Split) -> Mapping[str, Mapping[str, float]]:
    """How well conditions of a part's sentences are read, by kind.

    Args:
        reader: fitted.
        dataset: the habits.
        part: of the entries; figures on ``train`` are optimistic.

    Returns:
        Nats per judgement (``nll``), nats when predicting the labels' frequencies (``frequencies``), and the share of
        sentences with a condition of the kind for which the right one of holds and fails is more probable (``right``).
    """
    said = said_in(dataset, part)
    x, y = examples(reader, said, reader.mentions(reader.sentences([one.text for one in said])))
    found = {}
    for k, kind in enumerate(KINDS):
        share, label = softmax(x[k] @ reader.shares[k]), y[:, k]
        usual, some = np.bincount(label, minlength=3) / len(label), label < 2
        found[kind] = {
            "nll": float(-np.log(share[np.arange(len(label)), label]).mean()),
            "frequencies": float(-(usual * np.log(np.maximum(usual, 1e-12))).sum()),
            "right": float((share[some, :2].argmax(1) == label[some]).mean()),
        }
    return found


def fit_probe(vectors: Array, has: Array) -> Array:
    """Weights and bias (D + 1, 4) of logistic regressions from vectors (n, D) to kinds of conditions (n, 4)."""
    x, y = torch.tensor(np.c_[vectors, np.ones(len(vectors))]), torch.tensor(has)

    def loss(weight: torch.Tensor) -> torch.Tensor:
        each = functional.binary_cross_entropy_with_logits(x @ weight, y, reduction="none")
        return each.mean(0).sum() + PROBE_L2 * (weight[:-1] ** 2).sum()

    return _least((x.shape[1], y.shape[1]), loss)


def _fit_shares(x: Array, label: NDArray[np.int64]) -> Array:
    """Weights (N_FEATURES, 3) of a softmax regression."""
    inputs, right = torch.tensor(x), torch.tensor(label)

    def loss(weight: torch.Tensor) -> torch.Tensor:
        return functional.cross_entropy(inputs @ weight, right) + SHARES_L2 * (weight**2).sum()

    return _least((x.shape[1], 3), loss)


def _least(shape: tuple[int, int], loss: Callable[[torch.Tensor], torch.Tensor]) -> Array:
    """Weights of a shape with the least loss, found by L-BFGS from 0, float64."""
    weight = torch.zeros(shape, dtype=torch.float64, requires_grad=True)
    optimiser = torch.optim.LBFGS([weight], max_iter=200, line_search_fn="strong_wolfe")

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        value = loss(weight)
        value.backward()
        return value

    optimiser.step(closure)
    return np.asarray(weight.detach().numpy())


def _folds(said: Sequence[Said]) -> NDArray[np.int64]:
    """(n,) number of each sentence's fold: categories are dealt out in alphabetical order."""
    number = {name: k % N_FOLDS for k, name in enumerate(sorted({one.category for one in said}))}
    return np.asarray([number[one.category] for one in said])
