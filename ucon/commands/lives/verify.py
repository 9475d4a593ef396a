"""``python -m ucon lives verify SET``: checks places, moves and every request."""

from __future__ import annotations

import argparse
import sys

_SHOWN = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("names", metavar="SET", nargs="+", help="named set or file")


def run(args: argparse.Namespace) -> int:
    """Verify sets.

    Args:
        args: parsed options.

    Returns:
        Exit code 0, or 1 if a life does not verify.
    """
    from ucon.core.output import stdout_to_stderr
    from ucon.core.progress import Progress
    from ucon.habits.book import contexts_book
    from ucon.lives.sets import load_lives
    from ucon.lives.verify import verify_life

    worst = 0
    for name in args.names:
        lives, problems = load_lives(name), []
        with stdout_to_stderr(), Progress(f"verifying {name}", len(lives), unit="lives") as bar:
            for number, life in enumerate(lives, 1):
                problems += [f"{life.id}: {line}" for line in verify_life(life, contexts_book())]
                bar.update(number)
        for line in problems[:_SHOWN]:
            sys.stderr.write(f"  {line}\n")
        found = f"{len(problems)} problems" if problems else f"all {len(lives)} lives verified"
        sys.stderr.write(f"{name}: {found}\n")
        worst = max(worst, int(bool(problems)))
    return worst
