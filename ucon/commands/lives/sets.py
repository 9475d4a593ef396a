"""``python -m ucon lives sets``: lists the sets of lives."""

from __future__ import annotations

import argparse
import sys


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """No options."""


def run(args: argparse.Namespace) -> int:
    """Print a line for every set; returns the exit code 0."""
    from ucon.lives.sets import life_sets, load_lives

    for name in life_sets():
        lives = load_lives(name)
        days, asked = sum(life.days for life in lives), sum(len(life.requests) for life in lives)
        changing = sum(life.change_day is not None for life in lives)
        sys.stdout.write(
            f"{name:12} {len(lives):3} lives, {days:4} days, {asked:5} requests; habits change in {changing}\n"
        )
    return 0
