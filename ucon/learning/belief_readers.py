"""What reads sentences for the belief head while it learns: fitted parts that did not see what they read.

The habit book's are dealt by category (:mod:`ucon.learning.crossfit`). Nothing that reads sentences was fitted on other
datasets; one that is bound to scenes brings its own common sense, learned on the pairs that are not being asked about.
"""

from __future__ import annotations

from dataclasses import dataclass

from ucon.habits.splits import entry_parts
from ucon.habits.types import HabitDataset
from ucon.language.pairs import default_pair_reader
from ucon.learning.belief_homes import Pair, pair_folds
from ucon.learning.crossfit import ReadEvidence, folds
from ucon.learning.fit_own_prior import fit_own_prior
from ucon.retrieval.household import FittedParts, default_parts, parts_with


@dataclass(frozen=True, eq=False)
class Fold:
    """Habits, and what reads them."""

    dataset: HabitDataset
    parts: FittedParts
    pairs: frozenset[Pair] | None = None
    """What is asked about; None: everything."""


def folds_of(dataset: HabitDataset, n_folds: int, used_folds: int | None) -> list[Fold]:
    """Pieces of a dataset, each with what reads it."""
    return scene_folds(dataset) if dataset.scenes else book_folds(dataset, n_folds, used_folds)


def parts_of(dataset: HabitDataset) -> FittedParts:
    """The parts that a head stands on in use."""
    return own_parts(dataset) if dataset.scenes else default_parts()


def book_folds(dataset: HabitDataset, count: int, used: int | None) -> list[Fold]:
    """The folds of a dataset, each with parts that were fitted on the others."""
    pairs = default_pair_reader()
    return [
        Fold(fold.dataset, FittedParts(fold.weights, pairs, ReadEvidence.of(fold, pairs)))
        for fold in folds(dataset, pairs, count, used)
    ]


def own_parts(dataset: HabitDataset) -> FittedParts:
    """The shipped parts with the common sense of all train entries."""
    parts = entry_parts(dataset)
    entries = [entry for entry in dataset.entries if parts[entry.id] == "train"]
    return parts_with(fit_own_prior(entries, default_pair_reader()))


def scene_folds(dataset: HabitDataset, count: int = 4) -> list[Fold]:
    """All habits, asked about some pairs at a time, with the common sense of the others."""
    pairs = default_pair_reader()
    return [
        Fold(dataset, parts_with(fit_own_prior(others, pairs)), asked) for asked, others in pair_folds(dataset, count)
    ]
