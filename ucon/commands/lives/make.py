"""``python -m ucon lives make SET``: makes a set of lives.

Lives made so far are stored in a file next to the set's (``.part``): the same command continues after an interruption.
"""

from __future__ import annotations

import argparse
import sys
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("name", metavar="SET", help="lives_mini, lives_val, lives_test, lives_long, lives_train")
    parser.add_argument("--out", type=Path, help="file to write (default: where the set is loaded from)")
    parser.add_argument("--limit", type=int, help="make only this many lives, from the first")
    parser.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    parser.add_argument(
        "--ray",
        nargs="?",
        const="",
        metavar="ADDRESS",
        help="make them on a Ray cluster: host:port or auto; without ADDRESS, one on this machine",
    )


def run(args: argparse.Namespace) -> int:
    """Make a set; returns the exit code 0."""
    from itertools import islice

    from ucon.core.errors import ConfigError
    from ucon.core.files import require_writable
    from ucon.core.output import stdout_to_stderr
    from ucon.core.progress import Progress
    from ucon.habits.book import contexts_book
    from ucon.lives.making.make_sets import make_lives
    from ucon.lives.making.plans import ENDLESS, life_orders
    from ucon.lives.sets import DATA, SUFFIX, check_suffix, save_lives

    if args.limit is not None and args.limit < 1:
        raise ConfigError(f"--limit {args.limit}: expected a whole number from 1 up")
    if args.out is None and args.limit is not None:
        raise ConfigError(f"--limit without --out: set '{args.name}' itself would be replaced; give --out FILE")
    if args.name == ENDLESS and args.limit is None:
        raise ConfigError(f"{ENDLESS} has no end; give --limit LIVES and --out FILE")
    orders = list(islice(life_orders(args.name, contexts_book()), args.limit))
    path = args.out or DATA / f"{args.name}{SUFFIX}"
    check_suffix(path)
    journal = path.with_name(f"{path.name}.part")
    require_writable(journal)
    with (
        stdout_to_stderr(),
        _pools(args.ray),
        Progress(f"making {args.name}", len(orders), unit="lives") as bar,
    ):
        workers = args.workers if args.ray is None else max(2, args.workers)
        lives = make_lives(orders, workers=workers, progress=bar.update, journal=journal)
    save_lives(lives, path)
    journal.unlink()
    sys.stderr.write(f"{len(lives)} lives written to {path} ({path.stat().st_size / 1024:.0f} KB)\n")
    return 0


def _pools(address: str | None) -> AbstractContextManager[None]:
    """Where lives are made: on this machine for None, else on the Ray cluster at an address; "" starts one."""
    if address is None:
        return nullcontext()
    from ucon.cluster.runner import RayRunner
    from ucon.core.pool import pools_from

    return pools_from(RayRunner(address or None).pool)
