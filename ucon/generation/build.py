"""The pipeline as one call: propose (the book's text), validate in PyBullet, verify, and write one dataset file.

Equal text, code and catalogue give equal bytes, whatever the number of processes and however often it was interrupted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ucon.core.files import require_writable, user_cache
from ucon.generation.validate import ANCHORS_TRIED, dataset_triples, validate
from ucon.generation.verify import Doubt, doubtful
from ucon.habits.book import BOOK_FOLDER, read_book
from ucon.habits.datafile import require_suffix, save_dataset
from ucon.habits.types import HabitDataset
from ucon.objects.catalogue import catalogue

#: Called with the name of the step, how much of it is done, and how much there is.
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class BuiltDataset:
    """What a build made."""

    dataset: HabitDataset
    path: Path
    steps: dict[str, Any]
    doubts: tuple[Doubt, ...]
    """Labels that the text does not bear out, the most doubtful first: for a person to read."""


def validation_folder() -> Path:
    """Where finished blocks of validation are kept by default."""
    return user_cache() / "validate"


def build(
    out: Path,
    *,
    book: Path = BOOK_FOLDER,
    work: Path | None = None,
    workers: int = 2,
    progress: Progress | None = None,
) -> BuiltDataset:
    """Make a dataset file of a folder in the habit book's format.

    Args:
        out: file to write, its name ending in ``.habits.xz``.
        book: folder of the text.
        work: where finished blocks are kept, so that an interrupted build goes on; default in the user's cache.
        workers: processes.
        progress: called as the steps go on.

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
    doubts = tuple(doubtful(dataset))
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
    """How many pairs of a sentence and a placement were looked at, and which labels the verifier doubts."""
    return {
        "pairs": sum(len(entry.habits) * len(entry.placements) for entry in dataset.entries),
        "doubted_supports": sum(doubt.labelled for doubt in doubts),
        "doubted_distractors": sum(not doubt.labelled for doubt in doubts),
    }


def validation_figures(dataset: HabitDataset, wanted: dict[str, list[Any]]) -> dict[str, Any]:
    """Counts of trials and refusals; ``implausible`` triples are refused by every home that was tried."""
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
