"""``python -m ucon episodes make SET`` and ``episodes verify SET``: makes and verifies sets of episodes.

Episodes made so far are stored in a file next to the set's (``.part``): the same command continues after an
interruption.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ucon.task.episode import Episode

_SHOWN = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    maker = actions.add_parser("make", help="sample, check and write a set")
    maker.add_argument(
        "name",
        metavar="SET",
        help="mini, train, val, test, test_large, val_context, test_context, official, official_held_out (with "
        "--habits PATH)",
    )
    maker.add_argument(
        "--task", default="paper", help="rules that the episodes are made under: paper, released_code, real_robot"
    )
    maker.add_argument(
        "--context", action="store_true", help="episodes state day, season and occasion, and follow them"
    )
    maker.add_argument("--out", type=Path, help="file to write (default, for whole sets: where the set is loaded from)")
    maker.add_argument("--limit", type=int, help="make only this many episodes, from the first")
    maker.add_argument("--habits", metavar="PATH", help="habit dataset by path; default: the embedded book")
    maker.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    verifier = actions.add_parser("verify", help="replay every stored solution")
    verifier.add_argument("names", metavar="SET", nargs="+", help="named set or file")


def run(args: argparse.Namespace) -> int:
    """Run the chosen action.

    Args:
        args: parsed options.

    Returns:
        Exit code 0, or 1 if an episode does not verify.
    """
    from ucon.core.output import stdout_to_stderr

    with stdout_to_stderr():
        return _make(args) if args.action == "make" else _verify(args)


def _make(args: argparse.Namespace) -> int:
    from ucon.configuration.wiring import load_dataset
    from ucon.core.errors import ConfigError
    from ucon.core.files import require_writable
    from ucon.habits.book import contexts_book
    from ucon.task.making.make_sets import hosted_orders, make_episodes
    from ucon.task.making.set_plans import CONTEXT_SETS, OFFICIAL_SETS, set_orders
    from ucon.task.sets import check_suffix, save_episodes, set_name, set_path

    # The official sets need --habits, so with it they may be written to their own place; a part of a set may not.
    other = [("--habits", args.habits and args.name not in OFFICIAL_SETS), ("--limit", args.limit is not None)]
    if args.out is None and (given := [option for option, value in other if value]):
        raise ConfigError(f"{given[0]} without --out: set '{args.name}' itself would be replaced; give --out FILE")
    of_contexts = args.name in CONTEXT_SETS
    dataset = contexts_book() if of_contexts and not args.habits else load_dataset(args.habits)
    name = set_name(args.name, args.task, context=args.context)
    planned = set_orders(args.name, dataset, args.task, context=args.context, left_out=_say)
    if args.habits and args.name not in OFFICIAL_SETS:
        orders = hosted_orders(
            planned, dataset, limit=args.limit, context=args.context, workers=args.workers, left_out=_say
        )
    else:
        orders = list(islice(planned, args.limit))
    if not orders:
        raise ConfigError(f"dataset '{dataset.name}': none of its entries can be placed in a home of set '{args.name}'")
    path = args.out or set_path(name)
    check_suffix(path)
    journal = path.with_name(f"{path.name}.part")
    require_writable(journal)
    custom = dataset if args.habits or of_contexts else None
    with _bar(f"making {name}", len(orders)) as progress:
        episodes = make_episodes(
            orders,
            custom,
            task=args.task,
            context=args.context or of_contexts,
            even=of_contexts,
            workers=args.workers,
            progress=progress,
            journal=journal,
        )
    save_episodes(episodes, path)
    journal.unlink()
    sys.stderr.write(f"{len(episodes)} episodes written to {path} ({path.stat().st_size / 1024:.0f} KB)\n")
    return _report(path, episodes)


def _say(line: str) -> None:
    sys.stderr.write(f"{line}\n")


def _verify(args: argparse.Namespace) -> int:
    from ucon.task.sets import load_episodes

    return max(_report(name, load_episodes(name)) for name in args.names)


def _report(name: str | Path, episodes: Sequence[Episode]) -> int:
    from ucon.task.making.make_sets import verify_episode

    problems = []
    with _bar(f"verifying {name}", len(episodes)) as progress:
        for number, episode in enumerate(episodes, 1):
            if wrong := verify_episode(episode):
                problems.append(f"{episode.id}: {wrong}")
            progress(number, len(episodes))
    for line in problems[:_SHOWN]:
        sys.stderr.write(f"  {line}\n")
    found = (
        f"{len(problems)} of {len(episodes)} episodes are wrong"
        if problems
        else f"all {len(episodes)} episodes verified"
    )
    sys.stderr.write(f"{name}: {found}\n")
    return 1 if problems else 0


@contextmanager
def _bar(label: str, total: int) -> Iterator[Callable[[int, int], None]]:
    from ucon.core.progress import Progress

    with Progress(label, total, unit="episodes") as progress:
        yield lambda done, _: progress.update(done)
