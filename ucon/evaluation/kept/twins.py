"""Finds equal runs: an agent that reads no habits plays every habit level in the same way, so one run is enough."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ucon.core.errors import DataError
from ucon.evaluation.figures.report import NEUTRAL_OPTIONS
from ucon.evaluation.kept.finished import read_config
from ucon.evaluation.kept.seal import SUMMARY, read_files


def twin_of(out: Path, config: dict[str, Any], hashes: dict[str, str]) -> Path | None:
    """A finished run next to ``out`` that differs from this one only in its habit level.

    Args:
        out: folder of this run.
        config: its configuration.
        hashes: of :func:`ucon.evaluation.figures.report.run_hashes`.

    Returns:
        Folder of the other run; None where there is none.
    """
    wanted = without_level(config)
    for path in sorted(out.parent.glob(f"*/{SUMMARY}")):
        if path.parent == out:
            continue
        try:
            found = read_files(path.parent).summary["hashes"]
            other = read_config(path.parent)
            same = all(found.get(name) == value for name, value in hashes.items() if name != "config")
            if same and without_level(other) == wanted:
                return path.parent
        except (OSError, LookupError, AttributeError, DataError):
            continue  # other folders may be damaged or of another kind
    return None


def without_level(config: dict[Any, Any]) -> dict[str, Any]:
    """A configuration without neutral options and without those that depend on the habit level.

    Options of habits, retriever and environment do not matter to an agent that reads no habits.
    """
    left_out = (*NEUTRAL_OPTIONS, "habit_level", "retriever", "env")
    env = {name: value for name, value in config.get("env", {}).items() if name not in ("habit_level", "source")}
    return {str(name): value for name, value in config.items() if name not in left_out} | {"env": env}
