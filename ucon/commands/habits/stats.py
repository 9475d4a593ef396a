"""``python -m ucon habits stats``: figures and plots of a dataset, optionally next to another one."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ucon.evaluation.datasets.dataset_statistics import Measures


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument(
        "path", metavar="PATH", nargs="?", help="dataset file, task file or book folder; default: the embedded book"
    )
    parser.add_argument("--beside", metavar="PATH", help="another dataset to compare with (the official release)")
    parser.add_argument("--plots", metavar="FOLDER", type=Path, help="draw the figures as PNG files into a folder")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Measure one or two datasets, draw plots if asked for, and print the figures.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: no such path, or plots without matplotlib.
    """
    from ucon.configuration.wiring import load_dataset
    from ucon.core.files import require_writable
    from ucon.core.output import stdout_to_stderr
    from ucon.evaluation.datasets.dataset_statistics import measure
    from ucon.evaluation.datasets.plots import draw_plots, require_matplotlib

    plots = args.plots.expanduser() if args.plots else None
    if plots:  # check first: measuring takes minutes
        require_writable(plots / "plot.png")
        require_matplotlib()
    with stdout_to_stderr():
        found = [measure(load_dataset(args.path))]
        if args.beside:
            found.append(measure(load_dataset(args.beside)))
        drawn = draw_plots(found, plots) if plots else []
    figures = found[0].figures | {"plots": [str(path) for path in drawn]}
    if args.json:
        print(json.dumps(figures | ({"beside": found[1].figures} if args.beside else {}), indent=1))
        return 0
    _print(found)
    for path in drawn:
        print(path)
    return 0


def _print(found: Sequence[Measures]) -> None:
    """Print a table with a row per figure and a column per dataset."""
    from rich.table import Table

    from ucon.core.output import wide_console

    table = Table("figure", *[one.figures["dataset"] for one in found])
    columns = [dict(_flat(one.figures)) for one in found]
    for name in dict.fromkeys(name for column in columns for name in column):
        if name not in ("dataset", "sha256"):
            table.add_row(name, *[_shown(column.get(name)) for column in columns])
    wide_console().print(table)


def _flat(figures: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Nested figures as rows named by their path in the JSON, such as ``relations.ontop``."""
    for name, value in figures.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _shown(value: Any) -> str:
    return "-" if value is None else f"{value:,}" if isinstance(value, int) else str(value)
