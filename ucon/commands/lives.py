"""``python -m ucon lives make SET``, ``lives sets``, ``lives verify SET``, ``lives table RUN``.

Makes, lists and verifies sets of lives, and prints the tables of runs by day and by what the robot could know.

Lives made so far are stored in a file beside the set's (``.part``): the same command continues after an interruption.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

_SHOWN = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    maker = actions.add_parser("make", help="make, check and write a set")
    maker.add_argument("name", metavar="SET", help="lives_mini, lives_val, lives_test, lives_long")
    maker.add_argument("--out", type=Path, help="file to write; default: where the set is looked for")
    maker.add_argument("--limit", type=int, help="only the first so many lives")
    maker.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    actions.add_parser("sets", help="list the sets")
    tables = actions.add_parser("table", help="SR and SPL of runs of lives, by day and by what the robot could know")
    tables.add_argument("runs", metavar="RUN", nargs="+", type=Path, help="folder of a finished run")
    form = tables.add_mutually_exclusive_group()
    form.add_argument("--markdown", action="store_true", help="one table of SPL, a column a run")
    form.add_argument("--json", action="store_true", help="all figures as JSON")
    verifier = actions.add_parser("verify", help="check places, moves and every request")
    verifier.add_argument("names", metavar="SET", nargs="+", help="named set or file")


def run(args: argparse.Namespace) -> int:
    """Run the chosen action.

    Args:
        args: parsed options.

    Returns:
        Exit code 0, or 1 if a life does not verify.
    """
    from ucon.core.output import stdout_to_stderr

    if args.action == "sets":
        return _list()
    if args.action == "table":
        return _table(args)
    with stdout_to_stderr():
        return _make(args) if args.action == "make" else _verify(args.names)


def _list() -> int:
    from ucon.lives.sets import life_sets, load_lives

    for name in life_sets():
        lives = load_lives(name)
        days, asked = sum(life.days for life in lives), sum(len(life.requests) for life in lives)
        changing = sum(life.change_day is not None for life in lives)
        sys.stdout.write(
            f"{name:12} {len(lives):3} lives, {days:4} days, {asked:5} requests; habits change in {changing}\n"
        )
    return 0


def _table(args: argparse.Namespace) -> int:
    import json

    from rich.console import Console

    from ucon.core.errors import DataError
    from ucon.evaluation.figures.lives_table import figures_of, grouped, lives_markdown, lives_table
    from ucon.evaluation.kept.finished import FinishedRun
    from ucon.evaluation.kept.naming import agent_label, level

    found = []
    for path in args.runs:
        run = FinishedRun.read(path)
        records = run.records or ()
        if not records or any(record.life is None for record in records):
            raise DataError(f"{path}: no records of lives; expected a run of python eval.py task=resident")
        found.append((f"{agent_label(run.summary)}, {level(run.summary)}", records))
    if args.json:
        data = [
            {"run": str(path), "label": label, "groups": {name: figures_of(part) for name, part in grouped(records)}}
            for path, (label, records) in zip(args.runs, found, strict=True)
        ]
        sys.stdout.write(json.dumps(data, indent=2) + "\n")
    elif args.markdown:
        sys.stdout.write(lives_markdown(found) + "\n")
    else:
        for label, records in found:
            Console().print(lives_table(label, records))
    return 0


def _make(args: argparse.Namespace) -> int:
    from itertools import islice

    from ucon.core.errors import ConfigError
    from ucon.core.files import require_writable
    from ucon.core.progress import Progress
    from ucon.habits.book import contexts_book
    from ucon.lives.making.make_sets import make_lives
    from ucon.lives.making.plans import life_orders
    from ucon.lives.sets import DATA, SUFFIX, check_suffix, save_lives

    if args.out is None and args.limit is not None:
        raise ConfigError(f"--limit without --out: set '{args.name}' itself would be replaced; give --out FILE")
    orders = list(islice(life_orders(args.name, contexts_book()), args.limit))
    path = args.out or DATA / f"{args.name}{SUFFIX}"
    check_suffix(path)
    journal = path.with_name(f"{path.name}.part")
    require_writable(journal)
    with Progress(f"making {args.name}", len(orders), unit="lives") as bar:
        lives = make_lives(orders, workers=args.workers, progress=bar.update, journal=journal)
    save_lives(lives, path)
    journal.unlink()
    sys.stderr.write(f"{len(lives)} lives written to {path} ({path.stat().st_size / 1024:.0f} KB)\n")
    return 0


def _verify(names: list[str]) -> int:
    from ucon.core.progress import Progress
    from ucon.habits.book import contexts_book
    from ucon.lives.sets import load_lives
    from ucon.lives.verify import verify_life

    worst = 0
    for name in names:
        lives, problems = load_lives(name), []
        with Progress(f"verifying {name}", len(lives), unit="lives") as bar:
            for number, life in enumerate(lives, 1):
                problems += [f"{life.id}: {line}" for line in verify_life(life, contexts_book())]
                bar.update(number)
        for line in problems[:_SHOWN]:
            sys.stderr.write(f"  {line}\n")
        found = f"{len(problems)} things do not hold" if problems else f"all {len(lives)} lives hold"
        sys.stderr.write(f"{name}: {found}\n")
        worst = max(worst, int(bool(problems)))
    return worst
