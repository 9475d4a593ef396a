"""``python -m ucon lives table RUN``: tables of runs of lives, by day and by what the robot could know."""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument("runs", metavar="RUN", nargs="+", type=Path, help="folder of a finished run")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--markdown", action="store_true", help="print one table of SPL, with a column per run")
    form.add_argument("--json", action="store_true", help="print all figures as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the tables; returns the exit code 0."""
    from rich.console import Console

    from ucon.core.errors import DataError
    from ucon.evaluation.figures.lives_table import figures_of, grouped, lives_markdown, lives_table
    from ucon.evaluation.kept.finished import FinishedRun

    runs = []
    for path in args.runs:
        run = FinishedRun.read(path)
        records = run.records or ()
        if not records or any(record.life is None for record in records):
            raise DataError(f"{path}: no records of lives; expected a run of python eval.py task=resident")
        runs.append((run.label, records))
    times = Counter(label for label, _ in runs)
    found = [
        (label if times[label] == 1 else f"{label}: {path.name}", records)
        for path, (label, records) in zip(args.runs, runs, strict=True)
    ]
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
