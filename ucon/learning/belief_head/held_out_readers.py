"""What reads sentences for the belief head while it learns: fitted parts that did not see what they read.

The habit book's are dealt by category (:mod:`ucon.learning.belief_head.crossfit`). A dataset that is bound to scenes
brings its own common sense, learned on the pairs that are not being asked about, and, where that is asked for, what
reads places in its sentences (:mod:`ucon.fitting.scene_evidence`), likewise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ucon.core.errors import ConfigError, brief
from ucon.fitting.scene_evidence import kept_scene_evidence, told_beforehand
from ucon.fitting.scene_prior import fit_scene_prior
from ucon.habits.splits import entry_parts
from ucon.habits.types import HabitDataset
from ucon.language.pairs import default_pair_reader
from ucon.learning.belief_head.crossfit import ReadEvidence, folds
from ucon.learning.belief_head.households import Pair, pair_folds
from ucon.learning.run.options import N_FOLDS
from ucon.readers.evidence import EvidenceReader
from ucon.readers.household import FittedParts, default_parts, parts_with, shipped_evidence
from ucon.readers.reader_weights import default_weights, load_arrays
from ucon.readers.scene_evidence import LAST, SceneEvidence


@dataclass(frozen=True, eq=False)
class Fold:
    """Habits, and what reads them."""

    dataset: HabitDataset
    parts: FittedParts
    pairs: frozenset[Pair] | None = None
    """What is asked about; None: everything."""


def folds_of(dataset: HabitDataset, n_folds: int, used_folds: int | None, scene_evidence: bool = False) -> list[Fold]:
    """Pieces of a dataset, each with what reads it.

    Raises:
        ConfigError: folds are asked for of a dataset that is bound to scenes, whose pairs are dealt into four.
    """
    if dataset.scenes and (n_folds, used_folds) != (N_FOLDS, None):
        raise ConfigError(
            f"learner.n_folds={brief(n_folds)}, learner.used_folds={brief(used_folds)}: are of habits without scenes; "
            f"{dataset.name} is dealt by scene, leave them out"
        )
    return (
        scene_folds(dataset, scene_evidence=scene_evidence)
        if dataset.scenes
        else book_folds(dataset, n_folds, used_folds)
    )


def parts_of(dataset: HabitDataset, scene_evidence: bool = False) -> FittedParts:
    """The parts that a head stands on in use."""
    return own_parts(dataset, scene_evidence) if dataset.scenes else default_parts()


def book_folds(dataset: HabitDataset, count: int, used: int | None) -> list[Fold]:
    """The folds of a dataset, each with parts that were fitted on the others."""
    pairs = default_pair_reader()
    return [
        Fold(fold.dataset, FittedParts(fold.weights, pairs, ReadEvidence.of(fold, pairs)))
        for fold in folds(dataset, pairs, count, used)
    ]


def own_parts(dataset: HabitDataset, scene_evidence: bool = False) -> FittedParts:
    """The shipped parts with the common sense of all train entries, and what reads places learned from them."""
    parts, pairs = entry_parts(dataset), default_pair_reader()
    entries = [entry for entry in dataset.entries if parts[entry.id] == "train"]
    folder = kept_scene_evidence(dataset, entries, pairs) if scene_evidence else None
    return parts_with(fit_scene_prior(entries, pairs), folder)


def scene_folds(dataset: HabitDataset, count: int = 4, *, scene_evidence: bool = False) -> list[Fold]:
    """All habits, asked about some pairs at a time, with the common sense of the others.

    With ``scene_evidence`` half of the folds are read by what learned from the other half's entries.
    """
    pairs, weights, dealt = default_pair_reader(), default_weights(), pair_folds(dataset, count)
    readers: Sequence[EvidenceReader | SceneEvidence] = [shipped_evidence()] * len(dealt)
    if scene_evidence:
        readers = _read_by_others(dataset, [asked for asked, _ in dealt])
    return [
        Fold(dataset, FittedParts(weights, pairs, reader, fit_scene_prior(others, pairs)), asked)
        for reader, (asked, others) in zip(readers, dealt, strict=True)
    ]


def _read_by_others(dataset: HabitDataset, folds: list[frozenset[Pair]]) -> list[SceneEvidence]:
    """What reads each fold: learned from no entry of its half."""
    parts, pairs, relations = entry_parts(dataset), default_pair_reader(), shipped_evidence()
    half = len(folds) // 2
    readers = []
    for own in (folds[:half], folds[half:]):
        read = frozenset().union(*own)
        others = [e for e in dataset.entries if parts[e.id] == "train" and (e.scene or "", e.category) not in read]
        folder = kept_scene_evidence(dataset, others, pairs)
        arrays, sha256 = load_arrays(folder / LAST)
        told = told_beforehand(folder, dataset.texts)
        readers += [SceneEvidence(arrays, sha256, told, pairs, relations)] * len(own)
    return readers
