"""``python -m ucon home ACTION``: writes a home file to edit, and says what is built from one; a module per action."""

from __future__ import annotations

import argparse

from ucon.commands.home import check as home_check
from ucon.commands.home import new as home_new

_ACTIONS = {
    "new": (home_new, "write an example to start from: a flat of two rooms, three sentences, one lost mug"),
    "check": (home_check, "show what is built from a home file, what finds no place, and where things are"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's actions to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, (module, text) in _ACTIONS.items():
        module.add_arguments(actions.add_parser(name, help=text))


def run(args: argparse.Namespace) -> int:
    """Run the chosen action; returns its exit code."""
    return _ACTIONS[args.action][0].run(args)
