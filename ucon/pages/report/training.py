"""Makes the report of a training run: curves of what was learned, validation, and the model card."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.learning.run.run_folder import CARD, METRICS, check_run_folder, read_config, read_metrics, read_text
from ucon.pages.document import document, packed
from ucon.pages.thinning import thinned

#: Largest number of points of a curve; longer ones are thinned evenly.
_MOST_POINTS: Final = 600


def is_training_run(folder: Path) -> bool:
    """Whether a folder holds a run of ``train.py``."""
    return (folder / METRICS).is_file()


def build_training_report(folder: Path) -> str:
    """The report of a training run, as the text of an HTML file.

    Args:
        folder: of the run.

    Raises:
        DataError: it is damaged, or nothing was learned yet.
    """
    title, data = f"UcON: {folder.resolve().name}", {"index": packed(training_of(folder))}
    return document(title, ("theme.css", "report.css"), ("page.js", "charts.js", "packed.js", "training.js"), data)


def training_of(folder: Path) -> dict[str, Any]:
    """What is shown of a training run, as plain values.

    Args:
        folder: of the run; it may be unfinished.

    Returns:
        ``folder``, ``steps`` done, ``curves`` (by name, points of step and value), ``config`` (text) and ``card``
        (text, "" while there is none).

    Raises:
        DataError: it is damaged, or nothing was learned yet.
    """
    check_run_folder(folder)
    rows = read_metrics(folder)
    if not rows:
        raise DataError(f"{folder / METRICS}: no training step yet; try again after the first one")
    curves: dict[str, list[list[float]]] = {}
    for row in rows:
        for name, value in row.items():
            if name != "step" and type(value) in (int, float) and isfinite(value):
                curves.setdefault(name, []).append([row["step"], value])
    return {
        "folder": folder.resolve().name,
        "steps": max(row["step"] for row in rows),
        "curves": {name: thinned(points, _MOST_POINTS) for name, points in sorted(curves.items())},
        "config": read_config(folder).decode(errors="replace"),
        "card": read_text(folder / CARD) if (folder / CARD).is_file() else "",
    }
