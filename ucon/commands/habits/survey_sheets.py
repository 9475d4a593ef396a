"""``python -m ucon habits survey make|score``: makes rating sheets for people, and scores returned ones."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    steps = parser.add_subparsers(dest="step", metavar="STEP", required=True)
    make = steps.add_parser("make", help="draw a rating sheet (CSV and HTML) and its key")
    make.add_argument("--out", type=Path, required=True, metavar="FILE.csv", help="sheet to write")
    make.add_argument("--n", type=int, default=60, help="items, one per category (default 60)")
    make.add_argument("--seed", type=int, default=0, help="another seed draws other items (default 0)")
    make.add_argument("--habits", metavar="PATH", help="dataset file or book folder; default: the book")
    score = steps.add_parser("score", help="score returned sheets")
    score.add_argument("key", type=Path, metavar="KEY.csv", help="the key that was written with the sheet")
    score.add_argument("sheets", type=Path, nargs="+", metavar="SHEET.csv", help="filled-in sheets, one per rater")
    for step in (make, score):
        step.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Run the chosen step.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.

    Raises:
        ConfigError: a wrong option, or a dataset that is too small.
        DataError: a damaged sheet or key.
    """
    return _make(args) if args.step == "make" else _score(args)


def _make(args: argparse.Namespace) -> int:
    from ucon.configuration.wiring import load_dataset
    from ucon.core.errors import ConfigError
    from ucon.core.files import write_atomic
    from ucon.evaluation.datasets.survey import draw_items, key_csv, sheet_csv
    from ucon.evaluation.datasets.survey_page import sheet_html

    sheet = args.out.expanduser()
    if sheet.suffix != ".csv":
        raise ConfigError(
            f"--out {args.out}: expected a name ending in .csv; the page and the key are written next to it"
        )
    items = draw_items(load_dataset(args.habits), args.n, args.seed)
    page, key = sheet.with_suffix(".html"), sheet.with_suffix(".key.csv")
    write_atomic(sheet, sheet_csv(items))
    write_atomic(page, sheet_html(items, sheet.name))
    write_atomic(key, key_csv(items))
    swapped = sum(item.truth == "swapped" for item in items)
    if args.json:
        paths = {"sheet": str(sheet), "page": str(page), "key": str(key)}
        print(json.dumps({**paths, "items": len(items), "true": len(items) - swapped, "swapped": swapped}, indent=1))
    else:
        print(f"{len(items)} items, {swapped} of them with a swapped place\nfor raters: {sheet}, {page}")
        print(f"keep to yourself: {key}")
    return 0


def _score(args: argparse.Namespace) -> int:
    from ucon.core.errors import ConfigError
    from ucon.evaluation.datasets.survey import read_key, read_sheet
    from ucon.evaluation.datasets.survey_score import score_survey

    names = [path.stem for path in args.sheets]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise ConfigError(f"two sheets are called '{twice[0]}'; raters are named after their files, rename one")
    key = read_key(args.key)
    answers = [answer for path in args.sheets for answer in read_sheet(path, key)]
    figures = score_survey(key, answers)
    if args.json:
        print(json.dumps(figures, indent=1))
    else:
        _print(figures)
    return 0


def _print(figures: Mapping[str, Any]) -> None:
    from rich.table import Table

    from ucon.core.output import wide_console

    look = figures["look"]
    rows = {
        "real person's habit, 1 to 5": figures["real"],
        "would look there: true places": look["yes_true"],
        "would look there: swapped places": look["yes_swapped"],
        "true minus swapped": look["difference"],
        "Krippendorff's alpha, real (ordinal)": figures["alpha_real"],
        "Krippendorff's alpha, look (nominal)": figures["alpha_look"],
    }
    table = Table("figure", "mean", "95 %", "n", title=f"{figures['raters']} raters, {figures['items']} items")
    for name, found in rows.items():
        if found is None:
            table.add_row(name, "-", "not defined", "-")
        else:
            table.add_row(name, f"{found['mean']:.3f}", f"{found['low']:.3f} to {found['high']:.3f}", str(found["n"]))
    raters = Table("rater", "real", "yes, true", "yes, swapped")
    for rater, found in figures["by_rater"].items():
        raters.add_row(rater, *("-" if value is None else f"{value:.2f}" for value in found.values()))
    console = wide_console()
    console.print(table)
    console.print(raters)
