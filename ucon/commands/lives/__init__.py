"""``python -m ucon lives ACTION``: sets of lives, and tables of runs on them; a module per action."""

from __future__ import annotations

import argparse

from ucon.commands.lives import known as lives_known
from ucon.commands.lives import make as lives_make
from ucon.commands.lives import sets as lives_sets
from ucon.commands.lives import table as lives_table
from ucon.commands.lives import verify as lives_verify

_ACTIONS = {
    "make": (lives_make, "make, check and write a set"),
    "sets": (lives_sets, "list the sets"),
    "verify": (lives_verify, "check places, moves and every request"),
    "known": (lives_known, "measure how well robots came to know their households: habits inferred, places predicted"),
    "table": (lives_table, "print SR and SPL of runs of lives, by day and by what the robot could know"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's actions to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, (module, text) in _ACTIONS.items():
        module.add_arguments(actions.add_parser(name, help=text))


def run(args: argparse.Namespace) -> int:
    """Run the chosen action; returns its exit code."""
    return _ACTIONS[args.action][0].run(args)
