"""SR and SPL against the share of false sentences among the habits, one line per agent and kind of falsehoods.

Runs without habits are the floor: the same at every share.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from ucon.core.errors import DataError
from ucon.evaluation.figures.intervals import Interval, mean_interval, rate_interval
from ucon.evaluation.figures.markdown import Run
from ucon.evaluation.figures.plotting import ABOVE, STYLE, new_figure, percent_axis, save_png
from ucon.evaluation.kept.finished import read_config
from ucon.evaluation.kept.record import EpisodeRecord

_COLORS: Final = ("#0f766e", "#d97706", "#5b4bb7", "#b3261e", "#4d7c0f", "#6b7280")
#: Kind of runs without falsehoods: they begin the line of the adversarial ones.
_WITHOUT: Final = "adversarial"
#: "Kind" of runs at level ``none``.
_FLOOR: Final = "no habits"

Lines = dict[str, dict[float, Sequence[EpisodeRecord]]]


def false_shares(runs: Mapping[Path, Run]) -> Lines:
    """Records by agent and kind of falsehoods, and by share; all on the episodes that every run has played.

    Args:
        runs: runs by folder; the configuration in the folder gives kind and share.

    Returns:
        Lines of at least two shares, and constant lines of runs without habits; {} where no run has falsehoods.
    """
    common = set.intersection(*({r.episode for r in run.records} for run in runs.values()))
    lines: Lines = {}
    for folder, run in runs.items():
        records = [r for r in run.records if r.episode in common]
        told = _told(folder)
        if records and told is not None:
            kind, share = told
            lines.setdefault(f"{records[0].agent}, {kind}", {})[share] = records
    if not any(share > 0.0 for line in lines.values() for share in line):
        return {}
    lines |= {name: {0.0: line[0.0], 1.0: line[0.0]} for name, line in lines.items() if name.endswith(_FLOOR)}
    return {name: dict(sorted(line.items())) for name, line in lines.items() if len(line) > 1}


def draw_false_shares(lines: Lines, path: Path) -> None:
    """Draw SR and SPL with their 95 % intervals against the share.

    Args:
        lines: as from :func:`false_shares`, at least one.
        path: of the picture (PNG).

    Raises:
        ConfigError: matplotlib is not installed.
    """
    import matplotlib

    n = len(next(iter(next(iter(lines.values())).values())))
    with matplotlib.rc_context(STYLE):
        figure = new_figure(10, 4.6, f"Success by the share of false sentences, {n} episodes")
        axes = figure.subplots(1, 2)
        for k, (name, line) in enumerate(lines.items()):
            rates = [rate_interval([r.success for r in records]) for records in line.values()]
            _draw(axes[0], list(line), rates, name, k)
            _draw(axes[1], list(line), [mean_interval([r.spl for r in records]) for records in line.values()], name, k)
        axes[0].set_title("SR", pad=20 + 14 * len(lines))
        axes[1].set_title("SPL", pad=20 + 14 * len(lines))
        percent_axis(axes[0].yaxis)
        axes[0].legend(fontsize=9, **ABOVE)
        save_png(figure, path)


def _draw(ax: Any, shares: Sequence[float], values: Sequence[Interval], name: str, k: int) -> None:
    reach: Any = [[v.mean - v.low for v in values], [v.high - v.mean for v in values]]
    at = [share + 0.008 * k for share in shares]  # shifted, so that intervals do not overlap
    color, style = _COLORS[k % len(_COLORS)], "--" if name.endswith(_FLOOR) else "o-"
    reach = None if name.endswith(_FLOOR) else reach
    ax.errorbar(at, [v.mean for v in values], yerr=reach, fmt=style, color=color, capsize=3, label=name)
    percent_axis(ax.xaxis)
    ax.set_xlabel("share of false sentences among those about the target's place")
    ax.grid(axis="y")


def _told(folder: Path) -> tuple[str, float] | None:
    """Kind and share of a run's falsehoods, the kind of the floor for a run without habits; None if not known."""
    try:
        config = read_config(folder)
    except DataError:  # records alone, or runs that are joined
        return None
    source = config.get("env", {}).get("source", {})
    if config.get("habit_level", {}).get("name") == "none":
        return _FLOOR, 0.0
    return source.get("falsehoods") or _WITHOUT, float(source.get("false_share") or 0.0)
