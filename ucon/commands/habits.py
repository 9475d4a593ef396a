"""``python -m ucon habits import PATH`` and ``habits stats``: read a dataset and say what is in it."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from ucon.commands import habits_build, habits_import

if TYPE_CHECKING:
    from ucon.habits import HabitDataset


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    habits_import.add_arguments(
        actions.add_parser("import", help="read a file of the official release, try every location")
    )
    stats = actions.add_parser("stats", help="variety, repetition and retrieval figures")
    stats.add_argument("path", metavar="PATH", nargs="?", help="task file or book folder; default: the embedded book")
    stats.add_argument("--json", action="store_true", help="print JSON")
    habits_build.add_arguments(actions.add_parser("build", help="make the dataset file: propose, validate, verify"))


def run(args: argparse.Namespace) -> int:
    """Carry out the chosen action; ``import`` ends with 1 where something was malformed."""
    if args.action == "build":
        return habits_build.run(args)
    return habits_import.run(args) if args.action == "import" else _stats(args)


def _stats(args: argparse.Namespace) -> int:
    from ucon.evaluation.habit_statistics import near_duplicates, retrieval_statistics, text_statistics
    from ucon.retrieval import DenseRetriever, dataset_vectors

    dataset = load_dataset(args.path)
    retriever = DenseRetriever()
    figures: dict[str, Any] = {"dataset": dataset.name, "sha256": dataset.sha256, **text_statistics(dataset)}
    figures["near_duplicates"] = near_duplicates(dataset_vectors(dataset, retriever.encoder))
    figures |= retrieval_statistics(dataset, retriever)
    if args.json:
        print(json.dumps(figures, indent=1))
    else:
        for name, value in figures.items():
            print(f"{name.replace('_', ' '):<24} {value}")
    return 0


def load_dataset(path: str | None) -> HabitDataset:
    """The dataset at a path: ``*.habits.xz`` a built file, JSON the official release, a folder of text a book."""
    from ucon.commands.wiring import existing, folder_habits, official_habits
    from ucon.habits import book
    from ucon.habits.datafile import SUFFIX

    if path is None:
        return book()
    found = existing(path, "PATH")
    is_book = found.name.endswith(SUFFIX) or (found.is_dir() and any(found.glob("*.txt")))
    return folder_habits(path) if is_book else official_habits(path)
