"""``python -m ucon habits ACTION``: import, propose, build, measure, show and survey datasets; a module per action."""

from __future__ import annotations

import argparse

from ucon.commands.habits import build as habits_build
from ucon.commands.habits import importing as habits_import
from ucon.commands.habits import propose as habits_propose
from ucon.commands.habits import show as habits_show
from ucon.commands.habits import stats as habits_stats
from ucon.commands.habits import survey_sheets as habits_survey

_ACTIONS = {
    "import": (habits_import, "read the official release and try every location in PyBullet"),
    "propose": (habits_propose, "let a language model propose new entries"),
    "build": (habits_build, "make the dataset file: propose, validate, verify"),
    "stats": (habits_stats, "measure variety, placements, homes and retrieval, and draw them"),
    "show": (habits_show, "print a category's entries, or the households of a scene"),
    "survey": (habits_survey, "make rating sheets for people, and score the returned ones"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's actions to its parser."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, (module, text) in _ACTIONS.items():
        module.add_arguments(actions.add_parser(name, help=text))


def run(args: argparse.Namespace) -> int:
    """Run the chosen action; returns its exit code."""
    return _ACTIONS[args.action][0].run(args)
