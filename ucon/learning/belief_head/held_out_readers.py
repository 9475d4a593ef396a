"""Readers of the belief head's training sentences, each fitted without the sentences that it reads.

The habit book's train categories are dealt into folds (:mod:`ucon.learning.belief_head.crossfit`). A dataset bound to
scenes has its own prior, fitted on the (scene, category) pairs that are not asked about. With ``scene_evidence`` it
also has its own reader of places (:mod:`ucon.fitting.scene_evidence`), fitted in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ucon.core.errors import ConfigError, brief
from ucon.fitting.scene_evidence import cached_scene_evidence, precomputed_vectors
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
    """A dataset, the parts that read it, and the pairs that are asked about."""

    dataset: HabitDataset
    parts: FittedParts
    pairs: frozenset[Pair] | None = None
    """(scene, category) pairs that are asked about; None: all."""


def folds_of(dataset: HabitDataset, n_folds: int, used_folds: int | None, scene_evidence: bool = False) -> list[Fold]:
    """Folds of a dataset, each with the parts that read it.

    Args:
        dataset: habits.
        n_folds: folds of categories, for a dataset without scenes.
        used_folds: how many of them to use; None: all.
        scene_evidence: for a dataset bound to scenes: read places with a reader fitted on it.

    Raises:
        ConfigError: ``n_folds`` or ``used_folds`` for a dataset bound to scenes, which is always dealt into four.
    """
    if dataset.scenes and (n_folds, used_folds) != (N_FOLDS, None):
        raise ConfigError(
            f"learner.n_folds={brief(n_folds)}, learner.used_folds={brief(used_folds)}: not for habits with scenes; "
            f"{dataset.name} is split by scene, leave them out"
        )
    return (
        scene_folds(dataset, scene_evidence=scene_evidence)
        if dataset.scenes
        else book_folds(dataset, n_folds, used_folds)
    )


def parts_of(dataset: HabitDataset, scene_evidence: bool = False) -> FittedParts:
    """The fitted parts that the trained head is used with.

    They are the dataset's own if it is bound to scenes, else the shipped ones.
    """
    return own_parts(dataset, scene_evidence) if dataset.scenes else default_parts()


def book_folds(dataset: HabitDataset, count: int, used: int | None) -> list[Fold]:
    """The first ``used`` of ``count`` folds of categories, each with parts fitted on the others."""
    pairs = default_pair_reader()
    return [
        Fold(fold.dataset, FittedParts(fold.weights, pairs, ReadEvidence.of(fold, pairs)))
        for fold in folds(dataset, pairs, count, used)
    ]


def own_parts(dataset: HabitDataset, scene_evidence: bool = False) -> FittedParts:
    """The shipped parts with the prior of all train entries.

    With ``scene_evidence`` also a reader of places fitted on them.
    """
    parts, pairs = entry_parts(dataset), default_pair_reader()
    entries = [entry for entry in dataset.entries if parts[entry.id] == "train"]
    folder = cached_scene_evidence(dataset, entries, pairs) if scene_evidence else None
    return parts_with(fit_scene_prior(entries, pairs), folder)


def scene_folds(dataset: HabitDataset, count: int = 4, *, scene_evidence: bool = False) -> list[Fold]:
    """Folds of a dataset bound to scenes, by (scene, category) pairs.

    Each fold has all habits, asks about its own pairs and uses the prior of the other folds' entries. With
    ``scene_evidence`` each half of the folds is read by a reader fitted on the other half's entries.

    Args:
        dataset: habits bound to scenes.
        count: number of folds.
        scene_evidence: fit readers of places.
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
    """Reader of places for each fold, fitted on no entry of that fold's half."""
    parts, pairs, relations = entry_parts(dataset), default_pair_reader(), shipped_evidence()
    half = len(folds) // 2
    readers = []
    for own in (folds[:half], folds[half:]):
        read = frozenset().union(*own)
        others = [e for e in dataset.entries if parts[e.id] == "train" and (e.scene or "", e.category) not in read]
        folder = cached_scene_evidence(dataset, others, pairs)
        arrays, sha256 = load_arrays(folder / LAST)
        vectors = precomputed_vectors(folder, dataset.texts)
        readers += [SceneEvidence(arrays, sha256, vectors, pairs, relations)] * len(own)
    return readers
