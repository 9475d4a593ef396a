"""``python -m ucon habits import``: what a file of the official release contains, and what homes can realise of it."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ucon.core.errors import ConfigError, DataError

if TYPE_CHECKING:
    from ucon.habits import ImportReport
    from ucon.task.making.placeable import Unplaced

_SHOWN = 20
_COUNTS = ("scenes", "categories", "tasks", "habits", "locations")


@dataclass(frozen=True)
class Imported:
    """A file that was read, with its locations that no home realises."""

    report: ImportReport
    rest: list[Unplaced]

    @property
    def counts(self) -> dict[str, int]:
        """All counts by name.

        The verdicts add up to the number of locations (``imported`` ones are among the ``placed``).
        """
        from ucon.task.making.placeable import counted

        held = {name: getattr(self.report, name) for name in _COUNTS}
        malformed = self.report.locations - len(self.report.located)
        return held | counted(self.report.located, self.rest) | {"malformed": malformed}

    def to_json(self) -> dict[str, Any]:
        """Plain values: counts and lists."""
        problems = [asdict(problem) for problem in self.report.problems]
        return {**self.counts, "problems": problems, "unplaced": [asdict(one) for one in self.rest]}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("path", metavar="PATH", help="task file, or the folder that holds it")
    parser.add_argument("--all", action="store_true", help="read every task file in the folder PATH")
    parser.add_argument("--static", action="store_true", help="judge locations by shapes only, within a second")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="processes (default: one per core)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Report on one file or all.

    Args:
        args: parsed options.

    Returns:
        Exit code 0, or 1 if something was malformed or unreadable.

    Raises:
        ConfigError: no such path, or ``--all`` with a file.
        DataError: no file of the release there.
    """
    from ucon.configuration.wiring import existing
    from ucon.habits.release import release_warnings, task_files

    path = existing(args.path, "PATH")
    if args.all and not path.is_dir():
        raise ConfigError(f"--all: {path} is a file; give the folder of the release's task files")
    warnings = release_warnings(path) if path.is_dir() else []
    if not args.all:
        done = _read(path, args)
        _print_json(done.to_json() | {"warnings": warnings}) if args.json else _print(done, warnings)
        return 1 if done.report.problems else 0
    files = task_files(path)
    if not files:
        raise DataError(f"{path}: no task file of the release in it; give the folder that holds {_known(path)}")
    return _all(path, files, warnings, args)


def _known(folder: Path) -> str:
    from ucon.habits.release import DEFAULT_FILE

    return f"{DEFAULT_FILE} and others (this one holds {sum(1 for _ in folder.iterdir())} other files)"


def _all(folder: Path, files: Sequence[Path], warnings: list[str], args: argparse.Namespace) -> int:
    """Report on every file; one that cannot be read is listed, and the others are still reported."""
    found: dict[str, Imported] = {}
    unusable: list[str] = []
    for file in files:
        try:
            found[file.relative_to(folder).as_posix()] = _read(file, args)
        except DataError as error:
            unusable.append(str(error))
    if args.json:
        reports = {name: done.to_json() for name, done in found.items()}
        _print_json({"files": reports, "unusable": unusable, "warnings": warnings})
    else:
        for name, done in found.items():
            print(f"== {name}")
            _print(done, [])
        _print_first("unusable", unusable)
        _print_first("warnings", warnings)
    return 1 if unusable or any(done.report.problems for done in found.values()) else 0


def _read(path: Path, args: argparse.Namespace) -> Imported:
    from ucon.core.output import stdout_to_stderr
    from ucon.generation.kept import tried
    from ucon.habits import official
    from ucon.objects.catalogue import catalogue
    from ucon.task.making.placeable import unplaced

    with stdout_to_stderr():
        dataset, report = official(path, catalogue().names)
        verdicts = None
        if not args.static:
            with _bar(f"placing {report.path.name}") as progress:
                verdicts = tried(dataset, workers=args.workers, progress=progress)
        return Imported(report, unplaced(report.located, verdicts))


@contextmanager
def _bar(label: str) -> Iterator[Callable[[int, int], None]]:
    """Progress line that appears with the first trial; none where all verdicts are cached."""
    from ucon.core.progress import Progress

    with ExitStack() as stack:
        shown: list[Progress] = []

        def progress(done: int, total: int) -> None:
            if not shown:
                shown.append(stack.enter_context(Progress(label, total, unit="locations")))
            shown[0].update(done)

        yield progress


def _print_json(value: dict[str, Any]) -> None:
    print(json.dumps(value, indent=1))


def _print(done: Imported, warnings: Sequence[str]) -> None:
    counts = done.counts
    print(", ".join(f"{counts[name]} {name}" for name in _COUNTS))
    _print_first("malformed", done.report.problems)
    _print_first("not placed", done.rest)
    _print_first("warnings", warnings)
    verdicts = [f"{value} {name}".replace("_", " ") for name, value in counts.items() if name not in _COUNTS]
    print(", ".join(verdicts))


def _print_first(title: str, lines: Sequence[object]) -> None:
    """The first 20 lines, and how many more there are."""
    if lines:
        print(f"{title}:")
    for line in lines[:_SHOWN]:
        print(f"  {line}")
    if len(lines) > _SHOWN:
        print(f"  ... and {len(lines) - _SHOWN} more (--json lists all)")
