"""Fits the embedded language model: ``python -m ucon data fit-language-encoder``, some minutes on one core.

Uses the stored ``val`` episodes: options are the distinct categories that stand in the home; the right one is the
anchor where the target was placed. First the temperatures are fitted by maximum likelihood over the levels none,
full, gt and retrieval together. Then the score of an option without labels is fitted, on questions with four options
among which the home's categories are dealt at random: each shows five (the right one among them), the first shows none.
The results go into :class:`ucon.language.models.encoder.EncoderWeights`; on ``test`` they are only measured.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from ucon.core.rng import stream
from ucon.envs.knowledge import HabitSource
from ucon.fitting.maximum_likelihood import minimised
from ucon.language.choice import Option, Question
from ucon.language.models.encoder import EncoderModel, EncoderWeights
from ucon.language.phrases import phrase
from ucon.language.store import default_encoder
from ucon.retrieval.levels import FIXED_LEVELS
from ucon.sim.cache import load_house
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

_OPTIONS: Final = 4
_SHOWN: Final = 5
"""Most labels of an option, where a frame would show few."""
_ABSENT: Final = -1e9


@dataclass(frozen=True, eq=False)
class Case:
    """One episode as plain names."""

    id: str
    target: str
    categories: tuple[str, ...]
    """Distinct categories that stand in the home, without the target's, in alphabetical order, with spaces."""
    right: int
    """Index of the category that the target was placed at."""
    habits: dict[str, tuple[str, ...]]
    """Habits by level."""


def case_of(episode: Episode, source: HabitSource) -> Case:
    """The case of an episode. Privileged: it reads the target's place, for fitting and measuring only.

    Args:
        episode: stored episode.
        source: gives the habits.
    """
    house, placed = load_house(episode.scene), episode.arrangement.objects
    standing = {item.category for item in house.spec.items} | {thing.category for thing in placed}
    names = sorted(standing - {episode.target_category})
    number = episode.target_object.anchor
    anchor = house.categories[number] if number < house.n_instances else placed[number - house.n_instances].category
    habits: dict[str, tuple[str, ...]] = {level: source.knowledge(episode, level).texts for level in FIXED_LEVELS}
    right = names.index(anchor)
    return Case(episode.id, phrase(episode.target_category), tuple(map(phrase, names)), right, habits)


def cases(name: str, limit: int | None = None) -> list[Case]:
    """Cases of a stored set of episodes.

    Args:
        name: of the set.
        limit: number of episodes; None: all.
    """
    source = HabitSource()
    return [case_of(episode, source) for episode in load_episodes(name)[:limit]]


def four_options(case: Case, level: str, most: int | None = None, *, hide: bool = False) -> tuple[Question, int]:
    """A question with four options among which the home's categories are dealt at random.

    Args:
        case: the episode.
        level: habit level.
        most: most labels of an option; the right category is always among them.
        hide: True: the first option shows no labels, as an open door does.

    Returns:
        The question, and the index of the right option.
    """
    order = stream(0, "encoder", case.id).permutation(len(case.categories))
    dealt = [list(order[i::_OPTIONS]) for i in range(_OPTIONS)]
    right = next(i for i, hand in enumerate(dealt) if case.right in hand)
    if most is not None:
        dealt[right].sort(key=lambda number: number != case.right)
        dealt = [hand[:most] for hand in dealt]
    labels = [tuple(sorted(case.categories[number] for number in hand)) for hand in dealt]
    if hide:
        labels[0] = ()
    options = tuple(Option(f"option {i}", shown) for i, shown in enumerate(labels))
    return Question(case.target, case.habits[level], options, "", ""), right


class _Batch:
    """Cosines of all cases at all levels, padded, as torch tensors."""

    def __init__(self, found: Sequence[Case]) -> None:
        import torch

        encoder = default_encoder()
        n, most = len(found), max(len(case.categories) for case in found)
        like = np.full((n, most), _ABSENT, np.float32)
        self.levels: dict[str, tuple[Any, Any]] = {}
        names = [encoder.encode(case.categories) for case in found]
        targets = encoder.encode([case.target for case in found])
        for i, vectors in enumerate(names):
            like[i, : len(vectors)] = vectors @ targets[i]
        for level in FIXED_LEVELS[1:]:
            widest = max(len(case.habits[level]) for case in found)
            about = np.full((n, widest), -9.0, np.float32)  # below any cosine: no weight, but a finite gradient
            said = np.zeros((n, most, widest), np.float32)
            for i, case in enumerate(found):
                habits = encoder.encode(case.habits[level])
                about[i, : len(habits)] = habits @ targets[i]
                said[i, : len(names[i]), : len(habits)] = names[i] @ habits.T
            self.levels[level] = torch.from_numpy(about), torch.from_numpy(said)
        self.like, self.there = torch.from_numpy(like), torch.from_numpy(like > _ABSENT)
        self.right = torch.tensor([case.right for case in found])[:, None]

    def loss(self, x: Any) -> Any:
        """Mean negative log-likelihood over levels, a scalar.

        ``x`` (5,): beta, then log of tau, tau_none, tau_habit, sigma.
        """
        import torch

        tau, tau_none, tau_habit, sigma = torch.exp(x[1:])
        logits = [self.like / tau_none]
        for about, said in self.levels.values():
            share = torch.log_softmax(about / tau_habit, 1)[:, None]
            mixed = sigma * torch.logsumexp(share + said / sigma, 2)
            logits.append(((1 - x[0]) * self.like + x[0] * mixed) / tau)
        each = [torch.log_softmax(torch.where(self.there, z, _ABSENT), 1).gather(1, self.right) for z in logits]
        return -torch.stack(each).mean()


def fit(found: Sequence[Case]) -> EncoderWeights:
    """Weights that make the true anchors most probable.

    Args:
        found: cases to fit on.
    """
    start = np.array([1.0, *np.log([0.1, 1.0, 0.06, 0.06])])
    bounds = [(0.0, 3.0), *[tuple(np.log(pair)) for pair in ((0.02, 1), (0.02, 20), (0.01, 1), (0.01, 1))]]
    best = minimised(_Batch(found).loss, start, bounds, 40)
    scales = [float(np.round(value, 4)) for value in np.exp(best[1:])]
    return fit_empty(EncoderWeights(round(float(best[0]), 3), *scales), found)


def fit_empty(weights: EncoderWeights, found: Sequence[Case]) -> EncoderWeights:
    """Add the fitted scores of options without labels to the weights.

    Args:
        weights: with everything else fitted.
        found: cases to fit on.
    """
    from scipy.optimize import minimize_scalar

    # With a constant of 0 an empty option has logit 0, so the constant can be added to its score afterwards.
    bare = EncoderModel(replace(weights, empty=0.0, empty_none=0.0))
    best: dict[bool, float] = {}
    for with_habits in (False, True):
        levels = FIXED_LEVELS[1:] if with_habits else FIXED_LEVELS[:1]
        asked = [four_options(case, level, _SHOWN, hide=True) for case in found for level in levels]
        scores = np.array([answer.scores for answer in bare.answer([question for question, _ in asked])])
        right = np.array([number for _, number in asked])

        def loss(constant: float, scores: Any = scores, right: Any = right) -> float:
            moved = scores + np.eye(_OPTIONS)[0] * constant
            return float((np.logaddexp.reduce(moved, 1) - moved[np.arange(len(moved)), right]).mean())

        best[with_habits] = float(minimize_scalar(loss, bounds=(-30.0, 60.0), method="bounded").x)
    empty, none = best[True] * weights.tau, best[False] * weights.tau_none
    return replace(weights, empty=round(empty, 3), empty_none=round(none, 3))


def nats(model: EncoderModel, asked: Sequence[tuple[Question, int]]) -> float:
    """Mean negative log-likelihood of the right options.

    Args:
        model: what is measured.
        asked: questions, each with the index of the right option.
    """
    answers = model.answer([question for question, _ in asked])
    return -float(np.mean([answer.scores[right] for answer, (_, right) in zip(answers, asked, strict=True)]))


def single(case: Case, level: str) -> tuple[Question, int]:
    """A question with one option per category of the home, and the index of the right one."""
    options = tuple(Option(name, (name,)) for name in case.categories)
    return Question(case.target, case.habits[level], options, "", ""), case.right


def measured(found: Sequence[Case], weights: EncoderWeights) -> list[str]:
    """Lines of text: nats by habit level for four kinds of questions.

    Args:
        found: cases to measure on.
        weights: of the model.
    """
    kinds = {
        "categories": single,
        "four options": four_options,
        "four of few": lambda case, level: four_options(case, level, _SHOWN),
        "four of few, one without": lambda case, level: four_options(case, level, _SHOWN, hide=True),
    }
    lines = []
    for kind, ask in kinds.items():
        model = EncoderModel(weights)
        uniform = float(np.mean([np.log(len(ask(case, "none")[0].options)) for case in found]))
        levels = [f"{level} {nats(model, [ask(case, level) for case in found]):.3f}" for level in FIXED_LEVELS]
        lines.append(f"{kind}: {', '.join(levels)}, uniform {uniform:.3f}")
    return lines


def main(words: Sequence[str]) -> None:
    """Fit on ``val``, measure on ``val`` and ``test``, print.

    Args:
        words: of the command line.
    """
    argparse.ArgumentParser(prog="ucon data fit-language-encoder").parse_args(words)
    val = cases("val")
    weights = fit(val)
    lines = [f"{weights}"]
    for name, found in (("val", val), ("test", cases("test"))):
        lines += [f"{name}: {line}" for line in measured(found, weights)]
    print("\n".join(lines))  # noqa: T201
