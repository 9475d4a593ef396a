"""What the belief head learns from: households drawn anew at every step, at all habit levels together.

A draw is one knowledge base and some of its targets, each at a habit level of its own. To make the head read instead
of recalling, anchors may exchange their names (the truth and all that habits say of a place follow the place, the
name and what is usual of it do not), be read as if never met, be no candidates at all (their mass is the unseen), and
habits may be left out.
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
    """Labels of a :class:`HeadInputs`; float32."""

    anchor: NDArray[np.float32]  # (T, C + 1) probability of each candidate, and of the rest
    relation: NDArray[np.float32]  # (T, C, 4) probability of candidate and relation together
    relevant: NDArray[np.float32]  # (T, H) the habit is the target's
    weight: NDArray[
        np.float32
    ]  # (T, H) what that label counts; 0 where the habit is not given, or all are the target's


@dataclass(frozen=True)
class Draw:
    """How households are drawn.

    Raises:
        ConfigError: a share outside [0, 1], or a count below 1.
    """

    task_share: float = 0.6
    """Share of knowledge bases with one entry a category; the others hold all entries of a household."""
    targets: int = 8
    clutter: int = 12
    """Candidates that are no anchors of the dataset, as they stand about in homes."""
    swap: float = 0.15
    """Share of households in which :attr:`swapped` of the anchors exchange their names."""
    swapped: float = 0.4
    hide: float = 0.5
    """Share of households in which :attr:`hidden` of the anchors are read as if never met."""
    hidden: float = 0.1
    remove: float = 0.1
    """Share of households in which :attr:`removed` of the anchors are no candidates."""
    removed: float = 0.1
    drop: float = 0.3
    """Share of targets that lose :attr:`dropped` of their habits."""
    dropped: float = 0.15
    mute: float = 0.1
    """Share of households whose sentence vectors are withheld; always where names are exchanged."""
    levels: tuple[float, float, float, float] = (0.12, 0.3, 0.33, 0.25)
    """How often a target is given no habits, all, its own, the retrieved ones."""

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
    """One household: what is read, and what is true."""

    inputs: HeadInputs
    truth: Truth
    levels: tuple[Level, ...]  # (T,)


def given_mask(household: Household, kb: KnowledgeBase, target: str, level: Level) -> NDArray[np.bool_]:
    """(H,): the habits that a target is given at a level."""
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
    """Labels of some targets: the distribution that placements are drawn from, and whose each habit is.

    Habits that support no placement count little in the relevance: half of them say nothing that would tell.
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
    """What targets are given at levels, (T,) each, as it stands: no augmentation."""
    household, candidates = Household(parts, kb.texts), Candidates.of(names, parts)
    masks = [given_mask(household, kb, target, level) for target, level in zip(targets, levels, strict=True)]
    given, trusted = np.stack(masks), np.asarray([level == "gt" for level in levels])
    return Sample(
        household.inputs(targets, candidates, given, trusted),
        truth_of(kb, targets, candidates, given, trusted),
        tuple(levels),
    )


class Draws:
    """Draws samples from some entries, read by some fitted parts."""

    def __init__(
        self,
        parts: FittedParts,
        draw: Draw,
        others: Sequence[str] | None = None,
        pairs: Collection[tuple[str, str]] | None = None,
    ) -> None:
        """Describe the draws.

        Args:
            parts: read the habits.
            draw: what is drawn.
            others: names that are no anchors; by default the rest of the catalogue.
            pairs: of a scene and a target, which alone are asked about; None: all.
        """
        self.parts, self.draw, self.pairs = parts, draw, pairs
        self.others = list(catalogue().names if others is None else others)
        self._clutter: dict[frozenset[str], list[str]] = {}

    def mode(self, rng: np.random.Generator) -> Mode:
        """One entry a category, or all."""
        return "task" if rng.random() < self.draw.task_share else "category"

    def __call__(self, kb: KnowledgeBase, rng: np.random.Generator, anchors: Sequence[str] | None = None) -> Sample:
        """One augmented sample of a knowledge base, asked about ``anchors`` (by default those that the parts know).

        ``rng`` decides all.
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
        lose = (rng.random(len(targets)) < draw.drop)[:, None] & (rng.random(given.shape) < draw.dropped)
        trusted = np.asarray([level == "gt" for level in levels])
        given &= ~lose
        inputs = household.inputs(targets, candidates, given, trusted)
        forgotten = usual & ~candidates.known
        inputs = replace(inputs, prior=np.where(forgotten, np.float32(UNKNOWN_PRIOR), inputs.prior))
        truth = truth_of(kb, targets, candidates, given, trusted)
        chosen = Sample(inputs, truth, tuple(levels))
        if rng.random() < draw.swap:
            return swapped(chosen, candidates, targets, draw.swapped, rng)
        return muted(chosen) if rng.random() < draw.mute else chosen

    def _asked(self, kb: KnowledgeBase) -> list[str]:
        """Targets that may be asked about."""
        pairs = self.pairs
        return [t for t, e in kb.entries.items() if pairs is None or (e[0].scene or "", t) in pairs]

    def _others(self, anchors: frozenset[str]) -> list[str]:
        if anchors not in self._clutter:
            self._clutter[anchors] = [name for name in self.others if name not in anchors]
        return self._clutter[anchors]


def muted(one: Sample) -> Sample:
    """Without the sentence vectors."""
    return replace(one, inputs=replace(one.inputs, sentence=np.zeros_like(one.inputs.sentence)))


def swapped(
    one: Sample, candidates: Candidates, targets: Sequence[str], share: float, rng: np.random.Generator
) -> Sample:
    """Some anchors exchange names: what is said and true stays with the place, what is usual goes with the name.

    The sentence vectors still speak the old names, so they are withheld; so are the relations of what was exchanged.
    """
    may = candidates.known & ~np.isin(candidates.names, targets)
    chosen = np.flatnonzero(may & (rng.random(len(may)) < share))
    order = np.arange(len(may))
    order[chosen] = _deranged(chosen, rng)
    x = one.inputs
    inputs = replace(
        x, name=x.name[order], prior=x.prior[:, order], relation_prior=x.relation_prior[order], open=x.open[:, order]
    )
    relation = one.truth.relation.copy()
    relation[:, chosen] = 0
    return muted(replace(one, inputs=inputs, truth=replace(one.truth, relation=relation)))


def _deranged(chosen: NDArray[np.intp], rng: np.random.Generator) -> NDArray[np.intp]:
    """A cyclic exchange: nothing stays where it is."""
    ring = rng.permutation(chosen)
    order = dict(zip(ring, np.roll(ring, 1), strict=True))
    return np.asarray([order[i] for i in chosen])
