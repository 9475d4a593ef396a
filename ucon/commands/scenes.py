"""``python -m ucon scenes``: the homes as a table, as JSON, or as a sheet of plans and first-person views."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("--scene", action="append", metavar="NAME", help="only this home (may be repeated)")
    parser.add_argument("--sheet", type=Path, metavar="FILE.png", help="draw plans and views into a picture")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Print the homes, and draw the sheet if asked for.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.
    """
    from ucon.core.output import say_written, stdout_to_stderr, wide_console
    from ucon.scenes import SCENES

    names = tuple(args.scene or SCENES)
    with stdout_to_stderr():
        rows = [describe(name) for name in names]
        if args.sheet:
            draw(names, args.sheet)
            say_written(args.sheet, f"{len(names)} homes")
    if args.json:
        print(json.dumps(rows, indent=1))
    else:
        from rich.table import Table

        table = Table(*rows[0])
        for row in rows:
            table.add_row(*map(str, row.values()))
        wide_console().print(table)
    return 0


def describe(name: str) -> dict[str, Any]:
    """Figures of a home from its specification: kind, split, rooms, area in square metres, items, categories, hash.

    Args:
        name: of the home.
    """
    from ucon.scenes import home_spec, scene_split

    spec = home_spec(name)
    return {
        "scene": name,
        "kind": spec.kind,
        "split": scene_split(name),
        "rooms": len(spec.rooms),
        "area_m2": round(spec.area_m2, 1),
        "items": len(spec.items),
        "categories": len({item.category for item in spec.items}),
        "hash": spec.hash[:12],
    }


def draw(names: tuple[str, ...], path: Path) -> None:
    """Draw plans and views of some homes into a picture.

    Args:
        names: of the homes.
        path: of the PNG file.
    """
    from ucon.sim.sheets import scene_sheet

    scene_sheet(names, path)
