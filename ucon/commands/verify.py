"""``python -m ucon verify RUN ...``: recomputes the figures of finished runs from their records."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ucon.evaluation.kept.recompute import Verification


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("runs", nargs="+", metavar="RUN", type=Path, help="run folders of eval.py, or of results/")
    parser.add_argument(
        "--seal",
        action="store_true",
        help="add checksums to runs that an older version finished or from which files were removed, if all figures "
        "that can be recomputed agree",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")


def run(args: argparse.Namespace) -> int:
    """Check each run, and print a line for each.

    Args:
        args: parsed options.

    Returns:
        Exit code 0 if all figures and checksums are right, 1 if one differs, is missing or cannot be read.
    """
    from ucon.core.errors import UconError
    from ucon.evaluation.kept.recompute import verify

    good = True
    for folder in args.runs:
        try:
            found = verify(folder, seal=args.seal)
        except UconError as error:
            good = False
            print(f"error: {error}", file=sys.stderr, flush=True)
        else:
            good = good and found.good
            told = json.dumps({"run": str(folder), "good": found.good, **asdict(found)}) if args.json else _line(found)
            print(told if args.json else f"{folder}: {told}", flush=True)
    return 0 if good else 1


def _line(found: Verification) -> str:
    """One line of text about a run."""
    what = f"{found.label}, {found.n} episodes: "
    if found.differing:
        return f"{what}{len(found.differing)} figures are not what the records say ({', '.join(found.differing)})"
    sums = "the checksums are right" if found.sealed else "there are no checksums: --seal adds them"
    if not found.recomputed:
        return f"{what}figures alone, no records to recompute them from; {sums}"
    return (
        f"{what}{len(found.recomputed)} figures recomputed, all as stored; {sums}; "
        f"not recomputed: {', '.join(found.taken)}"
    )
