"""Fits a dataset's own prior (:mod:`ucon.readers.anchor_prior`), in seconds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import torch

from ucon.habits.types import Entry
from ucon.language.pairs import PairReader
from ucon.language.phrases import phrase
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_prior import AnchorPrior, scene_anchors
from ucon.readers.reader_weights import Array
from ucon.readers.sampled_homes import anchor_distribution

#: Pseudo-count of placements, spread over the relations.
_DOUBT: Final = 2.0


def fit_scene_prior(entries: Sequence[Entry], pairs: PairReader, l2: float = 2e-4) -> AnchorPrior:
    """Fit p(anchor | target) on entries bound to scenes; each competes only with the anchors of its scene.

    Args:
        entries: to fit on.
        pairs: encodes names.
        l2: penalty of the weights.
    """
    standing = scene_anchors(entries)
    names = tuple(sorted(set().union(*standing.values())))
    number = {name: i for i, name in enumerate(names)}
    x = torch.from_numpy(pairs.encoder.encode_half([phrase(e.category) for e in entries]).astype(np.float32))
    y, absent = torch.zeros(len(entries), len(names)), torch.ones(len(entries), len(names), dtype=torch.bool)
    for row, entry in enumerate(entries):
        for anchor, p in anchor_distribution([entry]).items():
            y[row, number[anchor]] = p
        absent[row, [number[anchor] for anchor in standing[entry.scene or ""]]] = False
    weight = torch.zeros(x.shape[1], len(names), requires_grad=True)
    bias = torch.zeros(len(names), requires_grad=True)
    optimiser = torch.optim.LBFGS([weight, bias], max_iter=100)

    def closure() -> torch.Tensor:
        optimiser.zero_grad()
        log_p = (x @ weight + bias).masked_fill(absent, -1e4).log_softmax(1)
        loss = -(y * log_p).sum(1).mean() + l2 * (weight**2).sum() + 0.1 * l2 * (bias**2).sum()
        loss.backward()  # type: ignore[no-untyped-call]
        return loss

    optimiser.step(closure)  # type: ignore[no-untyped-call]
    dense, usual = weight.detach().double().numpy(), bias.detach().double().numpy()
    return AnchorPrior(names, dense, usual, _relations(entries, names))


def _relations(entries: Sequence[Entry], names: Sequence[str]) -> Array:
    """p(relation | anchor), (A, 4), by smoothed counts."""
    number = {name: i for i, name in enumerate(names)}
    counts = np.full((len(names), len(RELATIONS)), _DOUBT / len(RELATIONS))
    for entry in entries:
        for place in entry.placements:
            counts[number[place.anchor], RELATIONS.index(place.relation)] += 1.0
    return np.asarray(counts / counts.sum(axis=1, keepdims=True))
