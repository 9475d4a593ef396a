"""The whole pipeline: the book's text, validation in PyBullet, verification, and one dataset file.

Equal text, code and catalogue give equal bytes, whatever the number of processes and of interruptions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ucon.core.files import require_writable, user_cache
from ucon.generation.validate import ANCHORS_TRIED, dataset_triples, validate
from ucon.generation.verify import Doubt, PairScorer, doubtful
from ucon.habits.book import BOOK_FOLDER, read_book
from ucon.habits.datafile import require_suffix, save_dataset
from ucon.habits.types import HabitDataset
from ucon.objects.catalogue import catalogue

#: Called with the name of the step, the amount done, and the amount of all.
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class BuiltDataset:
    """The result of a build."""

    dataset: HabitDataset
    """The entries with verdicts."""
    path: Path
    """The written file."""
    steps: dict[str, Any]
    """Numbers of each step, as stored in the file's header."""
    doubts: tuple[Doubt, ...]
    """Labels that the text does not confirm, the most doubtful first, for a person to check."""


def validation_folder() -> Path:
    """Default folder of finished blocks of validation, in the user's cache."""
    return user_cache() / "validate"


def build(
    out: Path,
    *,
    book: Path = BOOK_FOLDER,
    work: Path | None = None,
    workers: int = 2,
    verifier: PairScorer | None = None,
    progress: Progress | None = None,
) -> BuiltDataset:
    """Make a dataset file from a folder in the habit book's format.

    Args:
        out: file to write, its name ending in ``.habits.xz``.
        book: folder of the text.
        work: folder of finished blocks, so that an interrupted build is continued; by default in the user's cache.
        workers: processes.
        verifier: doubts labels; the shipped one by default.
        progress: called as the steps proceed.

    Raises:
        DataError: the text is malformed; names file and line.
        ConfigError: ``out`` cannot be written.
    """
    require_suffix(out)
    text = read_book(book, catalogue().names)
    require_writable(out)
    wanted = dataset_triples(text)

    def tried(done: int, total: int) -> None:
        if progress:
            progress("validate", done, total)

    verdicts = validate(wanted, work or validation_folder(), workers=workers, progress=tried)
    dataset = replace(text, verdicts=verdicts)
    doubts = tuple(doubtful(dataset, verifier))
    steps = {
        "propose": _proposed(dataset),
        "validate": validation_figures(dataset, wanted),
        "verify": _verified(dataset, doubts),
    }
    save_dataset(dataset, out, steps)
    return BuiltDataset(dataset, out, steps, doubts)


def _proposed(dataset: HabitDataset) -> dict[str, int]:
    return {
        "entries": len(dataset.entries),
        "habits": len(dataset),
        "categories": len(dataset.categories),
        "placements": sum(len(entry.placements) for entry in dataset.entries),
    }


def _verified(dataset: HabitDataset, doubts: Sequence[Doubt]) -> dict[str, int]:
    """Number of pairs of a sentence and a placement that were checked, and of doubted labels."""
    return {
        "pairs": sum(len(entry.habits) * len(entry.placements) for entry in dataset.entries),
        "doubted_supports": sum(doubt.labelled for doubt in doubts),
        "doubted_distractors": sum(not doubt.labelled for doubt in doubts),
    }


def validation_figures(dataset: HabitDataset, wanted: dict[str, list[Any]]) -> dict[str, Any]:
    """Counts of trials and refusals.

    ``implausible`` triples are refused by every home in which they were tried.

    Args:
        dataset: with verdicts.
        wanted: triples by home.
    """
    of = dataset.verdicts.of
    reasons = Counter(reason for verdict in of.values() for reason in verdict.refused.values())
    implausible = Counter(verdict.reason for verdict in of.values() if verdict.reason is not None)
    return {
        "triples": len(of),
        "trials": sum(len(triples) for triples in wanted.values()),
        "anchors_tried": ANCHORS_TRIED,
        "refused_trials": dict(sorted(reasons.items())),
        "implausible_triples": dict(sorted(implausible.items())),
    }
