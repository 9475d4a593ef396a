"""Pictures of a results page: SR over steps, runs from the lowest to the highest, and differences by subset."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Final

import numpy as np

from ucon.evaluation.figures.groups import GROUPS, in_order
from ucon.evaluation.figures.intervals import Interval, mean_interval, paired_difference, rate_interval
from ucon.evaluation.figures.markdown import Run
from ucon.evaluation.figures.plotting import ABOVE, INK, STYLE, new_figure, percent_axis, require_matplotlib, save_png
from ucon.evaluation.kept.record import EpisodeRecord

#: Colours of runs; with more runs they repeat, dashed.
_COLORS: Final = ("#0f766e", "#d97706", "#5b4bb7", "#b3261e", "#4d7c0f", "#9d4b8f")
_RESAMPLES: Final = 2_000
_STEPS: Final = 300
#: Subsets with fewer common episodes are not drawn.
_LEAST: Final = 10
_MOST_PAIRS: Final = 6
#: Groupings within which differences are drawn; single targets and homes have too few episodes.
_SUBSETS: Final = ("split", "relation", "kind of home", "size of home")
#: Groupings of the picture that shows when a difference is large, with their titles there.
_WHEN: Final = {
    "variety among households": "anchors over which\nhouseholds spread such a thing",
    "common sense": "what common sense says\nof the target's place",
    "size of home": "floor area of the home",
}


def plot_runs(runs: Sequence[Run], pairs: Sequence[tuple[Run, Run]], folder: Path) -> list[Path]:
    """Draw the pictures of some runs.

    Args:
        runs: at least one.
        pairs: first and second run of each paired difference; more than six are not drawn.
        folder: is created if missing.

    Returns:
        The files written.

    Raises:
        ConfigError: matplotlib is not installed.
    """
    require_matplotlib()
    import matplotlib

    drawn = {"sr_over_steps.png": lambda: _sr_over_steps(runs), "ladder.png": lambda: _ladder(runs)}
    if 0 < len(pairs) <= _MOST_PAIRS:
        drawn["differences.png"] = lambda: _differences(pairs)
        drawn["when.png"] = lambda: _when(pairs)
    folder.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        for name, draw in drawn.items():
            save_png(draw(), folder / name)
    return [folder / name for name in drawn]


def _sr_over_steps(runs: Sequence[Run]) -> Any:
    """Success rate within so many steps, with its 95 % interval at every tenth step."""
    figure = new_figure(8, 5, "Success rate within N steps")
    ax = figure.subplots()
    for k, run in enumerate(runs):
        ends = np.array([r.steps if r.success else _STEPS + 1 for r in run.records])
        found = ends[:, None] <= np.arange(_STEPS + 1)
        at = np.arange(0, _STEPS + 1, 10)
        limits = np.array([rate_interval(found[:, s], resamples=_RESAMPLES).ci95 for s in at])
        color = _COLORS[k % len(_COLORS)]
        ax.fill_between(at, limits[:, 0], limits[:, 1], color=color, alpha=0.13, linewidth=0)
        ax.plot(found.mean(0), color=color, linestyle="-" if k < len(_COLORS) else "--", label=run.label, linewidth=1.8)
    ax.set(xlim=(0, _STEPS), ylim=(0, None), xlabel="steps")
    percent_axis(ax.yaxis)
    ax.grid(axis="y")
    ax.legend(loc="lower right", fontsize=9)
    return figure


def _ladder(runs: Sequence[Run]) -> Any:
    """SR and SPL of the runs, from the lowest SPL to the highest."""
    spl = {run.label: mean_interval([r.spl for r in run.records], resamples=_RESAMPLES) for run in runs}
    ordered = sorted(runs, key=lambda run: spl[run.label].mean)
    rates = [rate_interval([r.success for r in run.records], resamples=_RESAMPLES) for run in ordered]
    names = [run.label for run in ordered]
    figure = new_figure(10, 1.6 + 0.38 * len(runs), "Runs from the lowest SPL to the highest")
    axes = figure.subplots(1, 2, sharey=True)
    _points(axes[0], [spl[name] for name in names], names, _COLORS[0], "{:.3f}")
    _points(axes[1], rates, names, _COLORS[1], "{:.1%}")
    axes[0].set_title("SPL")
    axes[1].set_title("SR")
    percent_axis(axes[1].xaxis)
    return figure


def _differences(pairs: Sequence[tuple[Run, Run]]) -> Any:
    """SPL of the first minus the second run of each pair, over all episodes and within subsets."""
    found = [_by_subset(*pair) for pair in pairs]
    names = list(dict.fromkeys(name for rows in found for name in rows))
    figure = new_figure(9.5, 1.9 + 0.3 * len(names), "Difference in SPL on the same episodes")
    ax = figure.subplots()
    for k, ((first, second), rows) in enumerate(zip(pairs, found, strict=True)):
        shift = (k - (len(pairs) - 1) / 2) * 0.7 / len(pairs)
        at = [names.index(name) + shift for name in rows]
        means = np.array([row.mean for row in rows.values()])
        reach = np.array([[row.mean - row.low, row.high - row.mean] for row in rows.values()]).T
        label = f"{first.label} minus {second.label}"
        ax.errorbar(
            means, at, xerr=reach, fmt="o", color=_COLORS[k % len(_COLORS)], capsize=2, markersize=5, label=label
        )
    ax.axvline(0, color=INK, linewidth=0.9)
    ax.set_yticks(range(len(names)), names)
    ax.invert_yaxis()
    ax.grid(axis="x")
    ax.legend(fontsize=9, **ABOVE)
    return figure


def _when(pairs: Sequence[tuple[Run, Run]]) -> Any:
    """SPL of the first minus the second run of each pair, by what may make habits pay off."""
    figure = new_figure(12, 4.6, "When it pays: difference in SPL on the same episodes")
    axes = figure.subplots(1, len(_WHEN), sharey=True)
    for ax, (title, called) in zip(axes, _WHEN.items(), strict=True):
        found = [_by_subset(*pair, (title,)) for pair in pairs]
        names = [name for name in dict.fromkeys(chain(*found)) if not name.startswith("all episodes")]
        for k, ((first, second), rows) in enumerate(zip(pairs, found, strict=True)):
            shown = [name for name in names if name in rows]
            at = [names.index(name) + (k - (len(pairs) - 1) / 2) * 0.6 / len(pairs) for name in shown]
            reach = np.array([[rows[n].mean - rows[n].low, rows[n].high - rows[n].mean] for n in shown]).T
            label = f"{first.label} minus {second.label}"
            means = [rows[n].mean for n in shown]
            ax.errorbar(at, means, yerr=reach, fmt="o", color=_COLORS[k % len(_COLORS)], capsize=3, label=label)
        ax.axhline(0, color=INK, linewidth=0.9)
        ax.set_xticks(range(len(names)), [name.replace(" (", "\n(") for name in names], fontsize=8)
        ax.set_xlabel(called)
        ax.grid(axis="y")
    axes[0].legend(fontsize=8, **ABOVE)
    return figure


def _by_subset(first: Run, second: Run, titles: Sequence[str] = _SUBSETS) -> dict[str, Interval]:
    """Paired difference in SPL within each subset, its size in the name."""
    others = {r.episode: r for r in second.records}
    common = [r for r in first.records if r.episode in others]
    found = {}

    def compare(name: str, part: Sequence[EpisodeRecord]) -> None:
        values = [r.spl for r in part], [others[r.episode].spl for r in part]
        found[f"{name} ({len(part)})"] = paired_difference(*values, resamples=_RESAMPLES)

    compare("all episodes", common)
    for title in titles:
        parts: dict[str, list[EpisodeRecord]] = {}
        for record in common:
            parts.setdefault(GROUPS[title](record), []).append(record)
        for name in sorted(parts, key=in_order):
            if _LEAST <= len(parts[name]) < len(common):
                compare(name, parts[name])
    return found


def _points(ax: Any, values: Sequence[Interval], names: Sequence[str], color: str, form: str) -> None:
    """Points with their intervals, one per row, each with its figure next to it."""
    for row, value in enumerate(values):
        reach = [[value.mean - value.low], [value.high - value.mean]]
        ax.errorbar([value.mean], [row], xerr=reach, fmt="o", color=color, capsize=3, markersize=6)
        ax.annotate(
            form.format(value.mean), (value.high, row), (6, 0), textcoords="offset points", va="center", fontsize=9
        )
    ax.set_yticks(range(len(names)), names)
    ax.grid(axis="x")
    ax.margins(x=0.16)
