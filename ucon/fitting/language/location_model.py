"""Fits the embedded language model's answers about places: ``python -m ucon data fit-location-model``, some minutes.

L3MVN compares the probability of one label between places, and that is what is fitted: of four places of a home, one of
them around the target's anchor, the true one should have the highest ``log p(target)``. (Fitted on the label instead,
the model learns that habits are mostly about the target, and raises it everywhere alike.) The levels none, full, gt and
retrieval of ``val`` have equal weight; ``test`` is only measured. The results go into
:class:`ucon.language.models.keeping.LocationWeights`.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.fitting.language.location_cases import LABELS, PLACES, PlaceCase, asked, place_cases
from ucon.fitting.maximum_likelihood import minimised
from ucon.language.models.encoder import EncoderModel
from ucon.language.models.keeping import LocationWeights, furniture_names
from ucon.language.store import default_encoder
from ucon.retrieval.levels import FIXED_LEVELS

#: Cosine of padding: gives no weight, and is finite.
_ABSENT = -1e3


class _Batch:
    """Cosines of all cases at all levels, padded, as torch tensors."""

    def __init__(self, found: Sequence[PlaceCase]) -> None:
        import torch

        encoder = default_encoder()
        furniture = encoder.encode(furniture_names())
        things = [sorted({thing for place in case.places for thing in place}) for case in found]
        labels = [encoder.encode(case.labels) for case in found]
        vectors = [encoder.encode(names) for names in things]
        share = np.zeros((len(found), PLACES, max(map(len, things))), np.float32)
        like = np.zeros((len(found), LABELS, share.shape[2]), np.float32)
        for i, (case, names) in enumerate(zip(found, things, strict=True)):
            like[i, :, : len(names)] = labels[i] @ vectors[i].T
            for k, place in enumerate(case.places):
                share[i, k, [names.index(thing) for thing in place]] = 1 / len(place)
        self.share = torch.from_numpy(share)  # (N, places, things)
        self.like = torch.from_numpy(like)  # (N, labels, things)
        self.usual = torch.from_numpy(np.stack([v @ furniture.T for v in labels]))  # (N, labels, furniture)
        self.levels: dict[str, tuple[Any, Any, Any]] = {}
        for level in FIXED_LEVELS[1:]:
            most = max(len(case.habits[level]) for case in found)
            about = np.full((len(found), LABELS, most), _ABSENT, np.float32)
            said = np.zeros((len(found), most, share.shape[2]), np.float32)
            usually = np.zeros((len(found), most, len(furniture)), np.float32)
            for i, case in enumerate(found):
                habits = encoder.encode(case.habits[level])
                about[i, :, : len(habits)] = labels[i] @ habits.T
                said[i, : len(habits), : len(things[i])] = habits @ vectors[i].T
                usually[i, : len(habits)] = habits @ furniture.T
            self.levels[level] = torch.from_numpy(about), torch.from_numpy(said), torch.from_numpy(usually)

    def logits(self, x: Any, level: str) -> Any:
        """(N, labels, places); ``x`` (7,): like, other, log about, named, log sigma, log weight, log doubt."""
        import torch

        if level == "none":
            return x[0] * (torch.bmm(self.like, self.share.mT) - self.usual.mean(2, keepdim=True))
        about, said, usually = self.levels[level]
        temperature, sigma, weight, doubt = torch.exp(x[[2, 4, 5, 6]])
        none = (x[3] / temperature).expand(len(about), 1, about.shape[2])
        share = torch.softmax(torch.cat([about / temperature, none], 1), 1)[:, :-1]
        usual = torch.bmm(torch.exp(-x[1] * self.usual / sigma), torch.exp(usually / sigma).mT) / usually.shape[2]
        fits = torch.bmm(share / usual, torch.exp(said / sigma)) * torch.exp(-x[1] * self.like / sigma)
        fits = torch.bmm(fits, self.share.mT)  # (N, labels, places)
        return weight * torch.log((doubt + fits) / (doubt + share.sum(2, keepdim=True)))

    def loss(self, x: Any) -> Any:
        """Mean negative log-likelihood of the true places over levels, a scalar."""
        import torch

        targets = [torch.log_softmax(self.logits(x, level), 1)[:, 0] for level in FIXED_LEVELS]
        return -torch.stack([torch.log_softmax(z, 1)[:, 0] for z in targets]).mean()


def fit(found: Sequence[PlaceCase]) -> LocationWeights:
    """Weights that make the true places most probable.

    Args:
        found: cases to fit on.
    """
    ranges = ((0.01, 1), (0.03, 1), (0.05, 10), (0.001, 100))
    about, sigma, weight, doubt = (tuple(np.log(pair)) for pair in ranges)
    bounds = [(0.0, 50.0), (0.0, 1.5), about, (0.0, 1.0), sigma, weight, doubt]
    start = np.array([8.8, 0.4, np.log(0.02), 0.45, *np.log([0.06, 0.7, 0.05])])
    return weights_of(minimised(_Batch(found).loss, start, bounds, 60))


def weights_of(x: NDArray[np.float64]) -> LocationWeights:
    """The weights that a point (7,) of the search stands for, rounded."""
    about, sigma, weight, doubt = (float(np.round(value, 4)) for value in np.exp(x[[2, 4, 5, 6]]))
    like, other, named = (round(float(value), 3) for value in x[[0, 1, 3]])
    return LocationWeights(like, other, about, named, sigma, weight, doubt)


def target_scores(found: Sequence[PlaceCase], level: str, model: EncoderModel) -> NDArray[np.float64]:
    """``log p(target)`` at each place, (N, places), as the model answers.

    Args:
        found: N cases.
        level: habit level.
        model: what is asked.
    """
    return np.array([[answer.scores[0] for answer in model.answer(asked(case, level))] for case in found])


def measured(found: Sequence[PlaceCase], weights: LocationWeights) -> list[str]:
    """Lines of text by habit level: share of true places found, nats, and quantiles of p.

    Args:
        found: cases to measure on.
        weights: of the model.
    """
    model, lines = EncoderModel(keeping=weights), []
    for level in FIXED_LEVELS:
        scores = target_scores(found, level, model)
        hit = float((scores.argmax(1) == 0).mean())
        nats = float((np.logaddexp.reduce(scores, 1) - scores[:, 0]).mean())
        spread = " ".join(f"{p:.3f}" for p in np.exp(np.quantile(scores, [0.1, 0.5, 0.9])))
        label = -float(scores[:, 0].mean())
        lines.append(f"{level}: true place {hit:.3f}, {nats:.4f} nats; target there {label:.3f} nats; p {spread}")
    uniform = f"{1 / PLACES:.3f}, {np.log(PLACES):.4f} nats; target there {np.log(LABELS):.3f} nats"
    return [*lines, f"uniform: true place {uniform}; p {1 / LABELS:.3f}"]


def main(words: Sequence[str]) -> None:
    """Fit on ``val``, measure on ``val`` and ``test``, print.

    Args:
        words: of the command line.
    """
    argparse.ArgumentParser(prog="ucon data fit-location-model").parse_args(words)
    val = place_cases("val")
    weights = fit(val)
    lines = [f"{weights}"]
    for name, found in (("val", val), ("test", place_cases("test"))):
        lines += [f"{name}: {line}" for line in measured(found, weights)]
    print("\n".join(lines))  # noqa: T201
