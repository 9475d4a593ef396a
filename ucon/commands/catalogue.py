"""``python -m ucon catalogue``: the object catalogue as counts, as JSON, or as a labelled contact sheet."""

from __future__ import annotations

import argparse
import json
from collections import Counter
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("--category", action="append", metavar="NAME", help="only this category (may be repeated)")
    parser.add_argument("--sheet", type=Path, metavar="FILE.png", help="draw a labelled contact sheet into a picture")
    parser.add_argument("--json", action="store_true", help="print the categories as JSON")


def run(args: argparse.Namespace) -> int:
    """Print counts or JSON, and draw the sheet if asked for.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.
    """
    from dataclasses import asdict

    from ucon.objects.catalogue import catalogue

    cat = catalogue()
    names = tuple(args.category or sorted(cat.names))
    rows = [cat[name] for name in names]
    if args.sheet:
        from ucon.core.output import say_written
        from ucon.sim.sheets import catalogue_sheet

        catalogue_sheet(names, args.sheet)
        say_written(args.sheet, f"{len(names)} categories")
    if args.json:
        print(json.dumps([asdict(row) for row in rows], indent=1))
    else:
        print(f"{len(rows)} categories, {len({row.archetype for row in rows})} archetypes")
        for title, count in (
            ("role", Counter(row.role for row in rows)),
            ("mount", Counter(row.mount for row in rows)),
            ("group", Counter(row.semantic_group for row in rows)),
        ):
            print(f"{title}: " + ", ".join(f"{name} {n}" for name, n in count.most_common()))
        print(
            f"openable: {sum(row.openable for row in rows)}, official targets: {sum(r.official_target for r in rows)}"
        )
    return 0
