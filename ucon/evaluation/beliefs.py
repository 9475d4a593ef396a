"""Measures a reader of habits: its belief against the true distribution that placements are drawn from.

Figures are exact expectations over that distribution, among given candidates, and not values for one drawn place. The
oracle's belief is the true distribution itself; a reader that does better has had access to it, which is reported as an
error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError
from ucon.evaluation.figures.intervals import Interval, mean_interval
from ucon.habits.knowledge import KnowledgeBase
from ucon.habits.types import Entry
from ucon.objects.model import RELATIONS
from ucon.readers.belief_scores import FIGURES, best_of, calibration_error, scores
from ucon.readers.protocol import Reader
from ucon.readers.sampled_homes import location_distribution
from ucon.retrieval.base import Retriever
from ucon.retrieval.levels import FIXED_LEVELS, Level, habits_at_level

Array = NDArray[np.floating]
ORACLE: Final = "oracle"
#: Tolerance for rounding.
_SLACK = 1e-6


@dataclass
class Measured:
    """Figures of one habit level: one value per target, in the order of measurement."""

    values: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in FIGURES})
    stated: list[Array] = field(default_factory=list)
    true: list[Array] = field(default_factory=list)
    clusters: list[str] = field(default_factory=list)
    """Scene and target of each value. Knowledge bases share them, so intervals resample whole clusters."""

    def add(self, p: Array, relation: Array, truth: Mapping[tuple[str, str], float], names: Sequence[str]) -> None:
        """Add one belief.

        Args:
            p: (C,) probabilities, which add up to 1.
            relation: (C, 4) p(relation | anchor).
            truth: probability of each (anchor, relation).
            names: the C candidates.
        """
        y = np.zeros((len(names), len(RELATIONS)))
        number = {name: i for i, name in enumerate(names)}
        for (anchor, how), value in truth.items():
            if anchor in number:
                y[number[anchor], RELATIONS.index(how)] += value  # type: ignore[arg-type]
        for name, value in scores(p, relation, y).items():
            self.values[name].append(value)
        stated, true = best_of(p, y.sum(1))
        self.stated.append(stated)
        self.true.append(true)

    @property
    def calibration_error(self) -> float:
        """Expected calibration error over the 20 best candidates of every belief."""
        return calibration_error(np.concatenate(self.stated), np.concatenate(self.true))

    def intervals(self) -> dict[str, Interval]:
        """Mean of each figure with its bootstrap interval."""
        return {name: mean_interval(values, clusters=self.clusters) for name, values in self.values.items()}


def measure_beliefs(
    kbs: Sequence[KnowledgeBase],
    reader: Reader,
    retriever: Retriever,
    candidates: Callable[[KnowledgeBase], Sequence[str]],
    about: Callable[[Entry], bool] = lambda _: True,
    levels: Sequence[Level] = FIXED_LEVELS,
) -> dict[str, Measured]:
    """Measure a reader's beliefs at each habit level, and the oracle's.

    Beliefs are normalised over the candidates, which include all true anchors.

    Args:
        kbs: knowledge bases.
        reader: the reader that is measured.
        retriever: for level ``retrieval``.
        candidates: gives the names of a knowledge base's candidate anchors.
        about: whether an entry counts; a target is measured only if all its entries count.
        levels: habit levels.

    Raises:
        DataError: a level is better than the oracle, or there is no target.
    """
    out = {name: Measured() for name in (*levels, ORACLE)}
    for kb in kbs:
        names = list(candidates(kb))
        for target, entries in kb.entries.items():
            if not all(map(about, entries)):
                continue
            truth = location_distribution(entries)
            own = [name for name in names if name != target]
            for level in levels:
                texts = [kb.dataset.texts[row] for row in habits_at_level(level, kb, target, retriever)]
                belief = reader.read(target, texts, trusted=level == "gt").belief(own)
                out[level].add(belief.p / belief.p.sum(), belief.relation, truth, own)
            out[ORACLE].add(*_oracle(truth, own), truth, own)
            for measured in out.values():
                measured.clusters.append(f"{entries[0].scene or ''}/{target}")
    if not out[ORACLE].clusters:
        raise DataError("no target to measure; choose another part, or more knowledge bases")
    _alarm(out)
    return out


def _oracle(truth: Mapping[tuple[str, str], float], names: Sequence[str]) -> tuple[Array, Array]:
    """The true distribution as a belief: (C,) and (C, 4)."""
    y = np.asarray([[truth.get((name, how), 0.0) for how in RELATIONS] for name in names])
    return y.sum(1), y


def _alarm(found: Mapping[str, Measured]) -> None:
    """Refuse figures that are better than the oracle's.

    Raises:
        DataError: naming level and figure.
    """
    best = {name: float(np.mean(values)) for name, values in found[ORACLE].values.items()}
    for level, measured in found.items():
        for name, values in measured.values.items():
            mean, sign = float(np.mean(values)), 1 if name.startswith(("hit", "relation")) else -1
            if sign * (mean - best[name]) > _SLACK:
                raise DataError(
                    f"level {level}: {name} {mean:.4f} is better than the oracle's {best[name]:.4f}, which knows all "
                    "places; the truth leaks into what is read"
                )
