"""``python -m ucon habits import PATH`` and ``habits stats``: read a dataset and say what is in it."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ucon.commands import habits_build

if TYPE_CHECKING:
    from ucon.habits import HabitDataset

_SHOWN = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    reader = actions.add_parser("import", help="read a file of the official release and report what does not fit")
    reader.add_argument("path", metavar="PATH", help="task file, or the folder that holds it")
    stats = actions.add_parser("stats", help="variety, repetition and retrieval figures")
    stats.add_argument("path", metavar="PATH", nargs="?", help="task file or book folder; default: the embedded book")
    habits_build.add_arguments(actions.add_parser("build", help="make the dataset file: propose, validate, verify"))
    for action in (reader, stats):
        action.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Carry out the chosen action; ``import`` ends with 1 where something was malformed."""
    if args.action == "build":
        return habits_build.run(args)
    return _import(args) if args.action == "import" else _stats(args)


def _import(args: argparse.Namespace) -> int:
    from ucon.commands.output import stdout_to_stderr
    from ucon.commands.wiring import existing
    from ucon.habits import official
    from ucon.objects.catalogue import catalogue
    from ucon.task.placeable import ABSENT, unplaced

    with stdout_to_stderr():
        _, report = official(existing(args.path, "PATH"), catalogue().names)
        rest = unplaced(report.located)
    counts = {name: getattr(report, name) for name in ("scenes", "categories", "tasks", "habits", "locations")}
    absent = sum(one.reason == ABSENT for one in rest)
    verdicts = {
        "placed": len(report.located) - len(rest),
        "implausible": len(rest) - absent,
        "absent_anchor": absent,
        "malformed": report.locations - len(report.located),
    }
    if args.json:
        lists = {"problems": [asdict(p) for p in report.problems], "unplaced": [asdict(one) for one in rest]}
        print(json.dumps(counts | verdicts | lists, indent=1))
    else:
        print(", ".join(f"{value} {name}" for name, value in counts.items()))
        _print_first("malformed", report.problems)
        _print_first("not placed", rest)
        print(f"{', '.join(f'{value} {name}' for name, value in verdicts.items())}".replace("_", " "))
    return 1 if report.problems else 0


def _print_first(title: str, lines: Sequence[object]) -> None:
    """The first of many lines, and how many more there are."""
    if lines:
        print(f"{title}:")
    for line in lines[:_SHOWN]:
        print(f"  {line}")
    if len(lines) > _SHOWN:
        print(f"  ... and {len(lines) - _SHOWN} more (--json lists all)")


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
