"""Result tables for the terminal and ``summary.json`` for scripts: figures with intervals, versions and hashes."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from rich.box import HEAVY_HEAD, SIMPLE_HEAD
from rich.table import Table

import ucon
from ucon.core.files import canonical_json, sha256_bytes, sha256_file
from ucon.evaluation.figures.metrics import summarise
from ucon.evaluation.kept.decisions import language_figures, seconds_per_decision
from ucon.evaluation.kept.naming import ANY_LEVEL, NameParts, agent_label, level
from ucon.evaluation.playing.play import PlayedEpisode
from ucon.lives.asked import Asked
from ucon.task.episode import Episode

#: Packages whose version can change a record.
_PACKAGES = ("numpy", "numba", "torch", "transformers", "gymnasium", "pybullet", "opencv-python-headless")

#: Number of episodes of the set ``test``.
_MANY: Final = 1000
#: With fewer episodes the figures are too imprecise to act on.
_FEW: Final = 30
#: Options that do not change what is measured, only where and how fast.
NEUTRAL_OPTIONS = ("out", "runner", "workers", "worker_timeout_s", "pictures", "progress")


def run_hashes(
    config: dict[str, Any], episodes: Sequence[Episode | Asked], weights: Sequence[str] | None
) -> dict[str, str]:
    """SHA-256 of everything that decides the records: configuration, episodes, habits, code and weights.

    Args:
        config: of the run; neutral options are left out.
        episodes: the episodes that are played.
        weights: names or fingerprints of the weights; None: unknown, since the weights are missing; they are then left
            out, so that a finished run can still be read.
    """
    measured = {key: value for key, value in config.items() if key not in NEUTRAL_OPTIONS}
    habits = sorted({episode.habits_hash for episode in episodes})
    return {
        "config": sha256_bytes(canonical_json(measured).encode()),
        "episodes": episodes_hash(episodes),
        "habits": habits[0] if len(habits) == 1 else sha256_bytes("".join(habits).encode()),
        "code": code_hash(),
    } | ({} if weights is None else {"weights": sha256_bytes(canonical_json(list(weights)).encode())})


def episodes_hash(episodes: Sequence[Episode | Asked]) -> str:
    """SHA-256 of episodes in their order, as ``summary.json`` names it."""
    return sha256_bytes("".join(episode.hash for episode in episodes).encode())


@lru_cache(maxsize=1)
def code_hash() -> str:
    """SHA-256 over sources and data of ``ucon`` and, in a clone, sources and prompts of ``models``."""
    package = Path(ucon.__file__).parent
    models = package.parent / "models"
    files = sorted([*_files(package, "*"), *_files(models, "*.py"), *_files(models, "*.txt")])
    parts = [f"{p.relative_to(package.parent).as_posix()} {sha256_file(p)}" for p in files]
    return sha256_bytes("\n".join(parts).encode())


def _files(folder: Path, pattern: str) -> Iterator[Path]:
    """Files below a folder, without caches and hidden files."""
    for path in folder.rglob(pattern):
        parts = path.relative_to(folder).parts
        if path.is_file() and "__pycache__" not in parts and not any(part.startswith(".") for part in parts):
            yield path


def versions() -> dict[str, str]:
    """Versions of Python, UcON and the packages that can change a record, by name."""
    found = {"python": platform.python_version(), "ucon": ucon.__version__}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def summary(played: Sequence[PlayedEpisode], hashes: dict[str, str], parts: NameParts | None = None) -> dict[str, Any]:
    """Content of ``summary.json``: everything that is equal in equal runs.

    Args:
        played: the episodes, in order.
        hashes: as from :func:`run_hashes`.
        parts: names of the run's language model and detector.
    """
    records = [p.record for p in played]
    return {
        "agent": records[0].agent,
        "habit_level": records[0].habit_level,
        **(parts or NameParts()).to_json(),
        **summarise(records),
        "language": language_figures([d for p in played for d in p.decisions], len(played)),
        "hashes": hashes,
        "versions": versions(),
    }


def seconds_of(played: Sequence[PlayedEpisode], seconds: float) -> dict[str, Any]:
    """Content of ``seconds.json``: wall time of the run, and the sum over its episodes.

    Args:
        played: the episodes.
        seconds: wall time of the run.
    """
    return {
        "seconds": round(seconds, 2),
        "episode_seconds": round(sum(p.timing.seconds for p in played), 2),
        "language_seconds": round(sum(p.timing.language_seconds for p in played), 2),
        "seconds_per_decision": seconds_per_decision([d for p in played for d in p.decisions]),
    }


def results_table(summaries: Sequence[dict[str, Any]], title: str | None = None, *, wide: bool = True) -> Table:
    """Table with one row per run; long names are folded, so no figure is cut off.

    Args:
        summaries: content of each run's ``summary.json``.
        title: of the table.
        wide: False fits into 80 columns, with fewer figures.
    """
    look = {"box": HEAVY_HEAD} if wide else {"box": SIMPLE_HEAD, "padding": (0, 1, 0, 0), "show_edge": False}
    table = Table(title=title, title_justify="left", **look)  # type: ignore[arg-type]
    table.add_column("agent", overflow="fold")
    table.add_column("habits", no_wrap=True)
    columns = [name for name, always in _COLUMNS.items() if wide or always]
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    for s in summaries:
        figures = _figures(s)
        table.add_row(agent_label(s), level(s), *(figures[column] for column in columns))
    return table


#: Columns of figures, and whether narrow tables have them.
_COLUMNS: Final = {
    "n": True, "SR % [95 %]": True, "SPL [95 %]": True, "SR 75": False, "SR 150": False, "SoftSPL": False,
    "steps": True, "recall@20": False, "MRR": False,
}  # fmt: skip


def _figures(s: dict[str, Any]) -> dict[str, str]:
    """Text of a row by column."""
    # An agent that reads no habits has no retrieval figures: they would depend on the level it was played at.
    retrieval = {"recall_20": None, "mrr": None} if level(s) == ANY_LEVEL else s["retrieval"]
    return {
        "n": str(s["n"]),
        "SR % [95 %]": f"{100 * s['success_rate']:.1f} [{_range(s['success_rate_ci95'], 100, 1)}]",
        "SPL [95 %]": f"{s['spl']:.3f}" + (f" [{_range(s['spl_ci95'], 1, 3)}]" if s["n"] > 1 else ""),
        "SR 75": f"{100 * s['success_75']:.1f}",
        "SR 150": f"{100 * s['success_150']:.1f}",
        "SoftSPL": f"{s['soft_spl']:.3f}",
        "steps": f"{s['steps']:.0f}",
        "recall@20": "-" if retrieval["recall_20"] is None else f"{retrieval['recall_20']:.2f}",
        "MRR": "-" if retrieval["mrr"] is None else f"{retrieval['mrr']:.2f}",
    }


def precision_line(figures: dict[str, Any]) -> str:
    """One line on how precisely this many episodes determine SR."""
    low, high = figures["success_rate_ci95"]
    n, half = figures["n"], 50 * (high - low)
    if n < _FEW:
        what = "episodes are" if n > 1 else "episode is"
        return f"{n} {what} too few to tell: SR may be anywhere from {100 * low:.0f} to {100 * high:.0f} %"
    better = round((_MANY / n) ** 0.5)
    more = f", with episodes=test by ±{half / better:.0f}" if better > 1 else ""
    return f"with {n} episodes SR is uncertain by about ±{half:.0f} points{more}"


def failure_line(figures: dict[str, Any]) -> str:
    """One line with the number of failures by cause."""
    causes = figures["failure_causes"]
    if not causes:
        return "no failures"
    ordered = sorted(causes.items(), key=lambda item: -item[1])
    return "failures: " + ", ".join(f"{cause.replace('_', ' ')} {count}" for cause, count in ordered)


def _range(ci95: Sequence[float], factor: float, digits: int) -> str:
    return f"{factor * ci95[0]:.{digits}f}, {factor * ci95[1]:.{digits}f}"
