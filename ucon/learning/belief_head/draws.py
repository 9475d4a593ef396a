"""Training samples of the belief head: a knowledge base, some of its targets with habit levels, and their true places.

To make the head read sentences instead of recalling what is usual, samples are augmented. Anchors may exchange names
(the truth and what the habits say stay with the place; the prior goes with the name). Anchors may be treated as
unknown, or be left out of the candidates (their probability then belongs to "unseen"). Habits may be left out.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.habits.knowledge import KnowledgeBase, Mode
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS
from ucon.readers.anchor_prior import UNKNOWN_PRIOR
from ucon.readers.head_inputs import HeadInputs
from ucon.readers.household import Candidates, FittedParts, Household
from ucon.readers.sampled_homes import location_distribution
from ucon.retrieval.base import ranked
from ucon.retrieval.levels import FIXED_LEVELS, TOP_P, Level


@dataclass(frozen=True, eq=False)
class Truth:
    """Labels for a :class:`HeadInputs` of T targets, C candidates and H habits; arrays of float32."""

    anchor: NDArray[np.float32]
    """(T, C + 1) probability of each candidate; the last column is everything that is no candidate."""
    relation: NDArray[np.float32]
    """(T, C, 4) joint probability of candidate and relation."""
    relevant: NDArray[np.float32]
    """(T, H) 1 where the habit is about the target, else 0."""
    weight: NDArray[np.float32]
    """(T, H) weight of that label; 0 where the habit is not given, or at level ``gt``, where all are relevant."""


@dataclass(frozen=True)
class Draw:
    """How training samples are drawn and augmented.

    Raises:
        ConfigError: a share outside [0, 1], or a count out of range.
    """

    task_share: float = 0.6
    """Share of knowledge bases with one entry per category; the others have all entries of a household."""
    targets: int = 8
    """Most targets of one sample."""
    clutter: int = 12
    """Number of candidates per sample that are no anchors of the dataset, as other objects stand about in homes."""
    swap: float = 0.15
    """Share of samples in which a share :attr:`swapped` of the anchors exchange their names."""
    swapped: float = 0.4
    hide: float = 0.5
    """Share of samples in which a share :attr:`hidden` of the anchors is treated as unknown."""
    hidden: float = 0.1
    remove: float = 0.1
    """Share of samples in which a share :attr:`removed` of the anchors is left out of the candidates."""
    removed: float = 0.1
    drop: float = 0.3
    """Share of targets that lose a share :attr:`dropped` of their habits."""
    dropped: float = 0.15
    mute: float = 0.1
    """Share of samples whose sentence vectors are zeroed; they always are where names are exchanged."""
    levels: tuple[float, float, float, float] = (0.12, 0.3, 0.33, 0.25)
    """Relative frequency of the habit levels ``none``, ``full``, ``gt`` and ``retrieval``, drawn for each target."""

    def __post_init__(self) -> None:
        counts = {"targets", "clutter", "levels"}
        for name, value in vars(self).items():
            if name not in counts and not (isinstance(value, (int, float)) and 0 <= value <= 1):
                raise ConfigError(f"draw.{name}={value}: expected a share from 0 to 1")
        if type(self.targets) is not int or type(self.clutter) is not int or self.targets < 1 or self.clutter < 0:
            raise ConfigError(f"draw.targets={self.targets}, draw.clutter={self.clutter}: expected at least 1 and 0")
        weights = self.levels if isinstance(self.levels, (list, tuple)) else ()
        numbers = all(type(w) in (int, float) and 0 <= w < 1e9 for w in weights)
        if len(weights) != len(FIXED_LEVELS) or not numbers or sum(weights) <= 0:
            raise ConfigError(f"draw.levels={self.levels}: expected {len(FIXED_LEVELS)} weights, {FIXED_LEVELS}")


@dataclass(frozen=True, eq=False)
class Sample:
    """Inputs and labels of one knowledge base."""

    inputs: HeadInputs
    truth: Truth
    levels: tuple[Level, ...]
    """Habit level of each of the T targets."""


def given_mask(household: Household, kb: KnowledgeBase, target: str, level: Level) -> NDArray[np.bool_]:
    """Which habits of a knowledge base a target is given at a level.

    Args:
        household: the knowledge base as the parts read it, for retrieval.
        kb: H habits.
        target: category that is looked for.
        level: habit level.

    Returns:
        (H,) bool.
    """
    if level == "none":
        return np.zeros(len(kb), bool)
    if level == "full":
        return np.ones(len(kb), bool)
    if level == "gt":
        return np.isin(kb.rows, kb.rows_about(target))
    return np.isin(kb.rows, ranked(household.cosines(target), kb.rows)[:TOP_P])


def truth_of(
    kb: KnowledgeBase,
    targets: Sequence[str],
    candidates: Candidates,
    given: NDArray[np.bool_],
    trusted: NDArray[np.bool_],
) -> Truth:
    """Labels of T targets: the distribution that placements are drawn from, and which habits are about each target.

    A habit that supports no placement has a small weight in the relevance: half of these do not say what they are
    about.

    Args:
        kb: H habits, and the entry of each target.
        targets: T categories.
        candidates: C candidates.
        given: (T, H) bool, habits that each target is given.
        trusted: (T,) bool, True at level ``gt``, where all given habits are relevant.
    """
    number = {name: i for i, name in enumerate(candidates.names)}
    anchor = np.zeros((len(targets), len(number) + 1), np.float32)
    relation = np.zeros((len(targets), len(number), len(RELATIONS)), np.float32)
    relevant = np.zeros(given.shape, np.float32)
    for t, target in enumerate(targets):
        for (name, how), p in location_distribution(kb.entries[target]).items():
            anchor[t, number.get(name, -1)] += p
            if name in number:
                relation[t, number[name], RELATIONS.index(how)] += p  # type: ignore[arg-type]
        relevant[t] = np.isin(kb.rows, kb.rows_about(target))
    speaks = np.asarray([bool(kb.dataset.habits[row].supports) or not kb.dataset.labelled for row in kb.rows])
    weight = (0.05 + speaks) * given * ~trusted[:, None]
    return Truth(anchor, relation, relevant, weight.astype(np.float32))


def sample(
    kb: KnowledgeBase, parts: FittedParts, names: Sequence[str], targets: Sequence[str], levels: Sequence[Level]
) -> Sample:
    """A sample without augmentation.

    Args:
        kb: the knowledge base.
        parts: read its habits.
        names: candidates.
        targets: T categories.
        levels: habit level of each target.
    """
    household, candidates = Household(parts, kb.texts), Candidates.of(names, parts)
    masks = [given_mask(household, kb, target, level) for target, level in zip(targets, levels, strict=True)]
    given, trusted = np.stack(masks), np.asarray([level == "gt" for level in levels])
    return Sample(
        household.inputs(targets, candidates, given, trusted),
        truth_of(kb, targets, candidates, given, trusted),
        tuple(levels),
    )


class Draws:
    """Draws augmented samples from knowledge bases."""

    def __init__(
        self,
        parts: FittedParts,
        draw: Draw,
        others: Sequence[str] | None = None,
        pairs: Collection[tuple[str, str]] | None = None,
    ) -> None:
        """Set what samples are drawn from.

        Args:
            parts: read the habits.
            draw: how samples are drawn.
            others: names that are no anchors, for clutter; by default the rest of the catalogue.
            pairs: (scene, target) pairs that may be asked about; None: all.
        """
        self.parts, self.draw, self.pairs = parts, draw, pairs
        self.others = list(catalogue().names if others is None else others)
        self._clutter: dict[frozenset[str], list[str]] = {}

    def mode(self, rng: np.random.Generator) -> Mode:
        """Draw the mode of a knowledge base: ``task`` (one entry per category) or ``category`` (all entries)."""
        return "task" if rng.random() < self.draw.task_share else "category"

    def __call__(self, kb: KnowledgeBase, rng: np.random.Generator, anchors: Sequence[str] | None = None) -> Sample:
        """One augmented sample.

        Args:
            kb: the knowledge base.
            rng: decides everything that is drawn.
            anchors: candidates before augmentation; by default those that the parts know.
        """
        draw = self.draw
        share = np.asarray(draw.levels) / sum(draw.levels)
        targets = [str(t) for t in rng.permutation(self._asked(kb))[: draw.targets]]
        levels = [FIXED_LEVELS[i] for i in rng.choice(len(FIXED_LEVELS), size=len(targets), p=share)]
        known = [*(self.parts.known if anchors is None else anchors)]
        others = self._others(frozenset(known))
        clutter = [str(n) for n in rng.choice(others, size=min(draw.clutter, len(others)), replace=False)]
        if rng.random() < draw.remove:
            known = [name for name in known if rng.random() >= draw.removed]
        candidates = Candidates.of([*known, *clutter], self.parts)
        usual = candidates.known
        if rng.random() < draw.hide:
            met = candidates.known & (rng.random(len(candidates.names)) >= draw.hidden)
            even = np.where(met[:, None], candidates.relation_prior, 1 / len(RELATIONS))
            candidates = replace(candidates, known=met, relation_prior=even)
        household = Household(self.parts, kb.texts)
        given = np.stack([given_mask(household, kb, t, level) for t, level in zip(targets, levels, strict=True)])
        is_dropped = (rng.random(len(targets)) < draw.drop)[:, None] & (rng.random(given.shape) < draw.dropped)
        trusted = np.asarray([level == "gt" for level in levels])
        given &= ~is_dropped
        inputs = household.inputs(targets, candidates, given, trusted)
        forgotten = usual & ~candidates.known
        inputs = replace(inputs, prior=np.where(forgotten, np.float32(UNKNOWN_PRIOR), inputs.prior))
        truth = truth_of(kb, targets, candidates, given, trusted)
        chosen = Sample(inputs, truth, tuple(levels))
        if rng.random() < draw.swap:
            return swapped(chosen, candidates, targets, draw.swapped, rng)
        return muted(chosen) if rng.random() < draw.mute else chosen

    def _asked(self, kb: KnowledgeBase) -> list[str]:
        """Targets of the knowledge base that may be asked about."""
        pairs = self.pairs
        return [t for t, e in kb.entries.items() if pairs is None or (e[0].scene or "", t) in pairs]

    def _others(self, anchors: frozenset[str]) -> list[str]:
        """Clutter names without the anchors; cached."""
        if anchors not in self._clutter:
            self._clutter[anchors] = [name for name in self.others if name not in anchors]
        return self._clutter[anchors]


def muted(one: Sample) -> Sample:
    """The sample with its sentence vectors set to 0."""
    return replace(one, inputs=replace(one.inputs, sentence=np.zeros_like(one.inputs.sentence)))


def swapped(
    one: Sample, candidates: Candidates, targets: Sequence[str], share: float, rng: np.random.Generator
) -> Sample:
    """Let some anchors exchange names: habits and truth stay with the place, prior and name embedding go with the name.

    The sentence vectors still contain the old names, so they are zeroed. The relations of exchanged anchors get no
    label.

    Args:
        one: the sample.
        candidates: its candidates; only known ones that are no targets are exchanged.
        targets: its targets.
        share: of the candidates to exchange, on average.
        rng: draws them.
    """
    eligible = candidates.known & ~np.isin(candidates.names, targets)
    chosen = np.flatnonzero(eligible & (rng.random(len(eligible)) < share))
    order = np.arange(len(eligible))
    order[chosen] = _deranged(chosen, rng)
    x = one.inputs
    inputs = replace(
        x, name=x.name[order], prior=x.prior[:, order], relation_prior=x.relation_prior[order], open=x.open[:, order]
    )
    relation = one.truth.relation.copy()
    relation[:, chosen] = 0
    return muted(replace(one, inputs=inputs, truth=replace(one.truth, relation=relation)))


def _deranged(chosen: NDArray[np.intp], rng: np.random.Generator) -> NDArray[np.intp]:
    """A cyclic permutation of the chosen indices: none keeps its place."""
    ring = rng.permutation(chosen)
    order = dict(zip(ring, np.roll(ring, 1), strict=True))
    return np.asarray([order[i] for i in chosen])
