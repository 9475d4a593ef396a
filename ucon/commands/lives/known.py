"""``python -m ucon lives known SET FOLDER``: how well robots got to know their households."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("lives", metavar="SET", help="set of lives, or a file")
    parser.add_argument("kept", metavar="FOLDER", type=Path, help="folder written by memory.keep=")
    parser.add_argument("--show", type=int, default=5, help="sentences to show for each life (default 5)")
    parser.add_argument("--json", action="store_true", help="print all figures as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the figures; returns the exit code 0."""
    from rich.console import Console

    from ucon.core.errors import DataError
    from ucon.core.progress import Progress
    from ucon.evaluation.drift import Drift, drift_table
    from ucon.evaluation.kept_memories import Known, examples, known_table
    from ucon.lives.sets import load_lives
    from ucon.memory.log_file import load_log, log_name

    lives = [life for life in load_lives(args.lives) if (args.kept / log_name(life.id)).is_file()]
    if not lives:
        raise DataError(f"{args.kept}: no memory of a life of {args.lives}; play them with memory.keep={args.kept}")
    known, drift, shown = Known(), Drift(), []
    with Progress("reading memories", len(lives), unit="lives") as bar:
        for number, life in enumerate(lives, 1):
            log = load_log(args.kept / log_name(life.id), life.id)
            known.add(life, log)
            drift.add(life, log)
            shown += [(life.id, text, right) for text, right in examples(log, life, args.show)]
            bar.update(number)
    if not (known.written and known.covered and known.tomorrow):
        raise DataError(f"{args.kept}: too little was seen there for any habit; play longer lives")
    if args.json:
        figures = known.to_json() | {"lives": len(lives), "drift": drift.to_json() if drift.lives else None}
        sys.stdout.write(json.dumps(figures, indent=2) + "\n")
        return 0
    Console().print(known_table(f"{len(lives)} lives of {args.lives}", known))
    if drift.lives:
        Console().print(drift_table(f"places of things whose habits changed, {len(drift.lives)} lives", drift))
    for life_id, text, right in shown:
        sys.stdout.write(f"{life_id}  {'' if right else '(no habit) '}{text}\n")
    return 0
