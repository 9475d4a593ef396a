"""``python -m ucon habits ACTION``: import, measure, show and survey datasets; most actions have a module."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from ucon.commands import habits_build, habits_propose, habits_show, habits_stats, habits_survey

if TYPE_CHECKING:
    from ucon.habits import HabitDataset

_SHOWN = 20
_ACTIONS = {
    "propose": (habits_propose, "let a language model propose new entries"),
    "build": (habits_build, "make the dataset file: propose, validate, verify"),
    "stats": (habits_stats, "variety, placements, homes and retrieval in figures and pictures"),
    "show": (habits_show, "a category's entries, or who lives in a scene, for reading"),
    "survey": (habits_survey, "make rating sheets for people, score the returned ones"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    reader = actions.add_parser("import", help="read a file of the official release and report what does not fit")
    reader.add_argument("path", metavar="PATH", help="task file, or the folder that holds it")
    reader.add_argument("--json", action="store_true", help="print JSON")
    for name, (module, text) in _ACTIONS.items():
        module.add_arguments(actions.add_parser(name, help=text))


def run(args: argparse.Namespace) -> int:
    """Carry out the chosen action; ``import`` ends with 1 where something was malformed."""
    return _import(args) if args.action == "import" else _ACTIONS[args.action][0].run(args)


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
