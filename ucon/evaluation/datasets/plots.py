"""Plots of one or two habit datasets, for slides and papers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ucon.evaluation.datasets.homes_of_habits import LONGEST
from ucon.evaluation.datasets.placements import CONTEXT_KINDS, anchor_shares, conditions
from ucon.evaluation.datasets.sentences import word_counts
from ucon.evaluation.figures.plotting import (
    ABOVE,
    BAND,
    COLORS,
    GREY,
    LIGHT,
    STYLE,
    grouped_bars,
    new_figure,
    percent_axis,
    require_matplotlib,
    save_png,
)
from ucon.habits.contexts import DAYS, EVENT_GROUPS, SEASONS, between
from ucon.habits.knowledge import MODES
from ucon.objects.model import RELATIONS

if TYPE_CHECKING:
    from ucon.evaluation.datasets.dataset_statistics import Measures

_TOP_ANCHORS = 40
#: Intended sizes of knowledge bases in the default mode (the paper's are above 300).
SIZEBAND = (300, 600)


def draw_plots(found: Sequence[Measures], folder: Path) -> list[Path]:
    """Write all plots of one or two datasets into ``folder``.

    Args:
        found: measures of each dataset.
        folder: for the PNG files.

    Returns:
        The files, in order.

    Raises:
        ConfigError: matplotlib is missing.
    """
    require_matplotlib()
    from matplotlib import rc_context

    paths = []
    with rc_context(STYLE):
        for name, draw in _PLOTS.items():
            paths.append(folder / f"{name}.png")
            save_png(draw(found), paths[-1])
    return paths


def _label(one: Measures) -> str:
    name = one.dataset.name
    return "habit book" if name == "book" else "official release" if name.startswith("official") else name


def _legend(ax: Any, found: Sequence[Measures], notes: Sequence[str]) -> None:
    """Legend of the datasets above the axes, each with a note."""
    from matplotlib.patches import Patch

    marks = [
        Patch(color=COLORS[k], label=f"{_label(one)}: {note}" if note else _label(one))
        for k, (one, note) in enumerate(zip(found, notes, strict=True))
    ]
    ax.legend(handles=marks, **ABOVE, ncols=2)


def _words(found: Sequence[Measures]) -> Any:
    """Words per habit: of two datasets, or of one dataset's habits that support a placement and those that do not."""
    figure = new_figure(title="Words per habit")
    ax = figure.subplots()
    series = [(_label(one), color, word_counts(one.dataset)) for one, color in zip(found, COLORS, strict=False)]
    if len(found) == 1 and found[0].dataset.labelled:
        tells = np.asarray([bool(habit.supports) for habit in found[0].dataset.habits])
        counts = series[0][2]
        series = [("name a place", COLORS[0], counts[tells]), ("name none", GREY, counts[~tells])]
    for name, color, counts in series:
        y = np.bincount(counts) / (len(found[0].dataset) if len(found) == 1 else len(counts))
        edges = np.arange(len(y) + 1) - 0.5
        low, mean, high = np.percentile(counts, 5), counts.mean(), np.percentile(counts, 95)
        label = f"{name}: mean {mean:.1f}, 5–95 % from {low:.0f} to {high:.0f}"
        ax.stairs(y, edges, fill=True, color=color, alpha=0.3, label=label)
        ax.stairs(y, edges, color=color, linewidth=2)
    percent_axis(ax.yaxis)
    last = max(float(np.percentile(counts, 99.9)) for _, _, counts in series)
    ax.set(xlabel="words", ylabel="habits", xlim=(1.5, last + 0.5))
    ax.set_xticks(range(5, int(last) + 1, 5))
    ax.grid(axis="y")
    ax.legend(**ABOVE, ncols=2)
    return figure


def _entries(found: Sequence[Measures]) -> Any:
    figure = new_figure(title="Households (entries) per target category")
    ax = figure.subplots()
    counts = [list(Counter(e.category for e in one.dataset.entries).values()) for one in found]
    last = 12 if max(map(max, counts)) > 12 else max(map(max, counts))
    rows = [np.bincount(np.minimum(c, last), minlength=last + 1)[1:] / len(c) for c in counts]
    names = [str(n) for n in range(1, last)] + [f"{last}+" if max(map(max, counts)) > last else str(last)]
    grouped_bars(ax, [list(row) for row in rows], names, lambda v: f"{100 * v:.0f}" if v >= 0.005 else "")
    percent_axis(ax.yaxis)
    ax.set(xlabel="entries", ylabel="categories")
    ax.grid(axis="y")
    notes = [f"{len(c)} categories, mean {np.mean(c):.1f}, most {max(c)}" for c in counts]
    _legend(ax, found, notes)
    return figure


def _anchors(found: Sequence[Measures]) -> Any:
    figure = new_figure(13, 6, title=f"Where things are kept: the {_TOP_ANCHORS} most frequent anchors")
    ax = figure.subplots()
    shares = [anchor_shares(one.dataset) for one in found]
    top = list(shares[0])[:_TOP_ANCHORS]
    ax.bar(range(len(top)), [shares[0][name] for name in top], 0.74, color=COLORS[0])
    if len(found) > 1:
        values = [shares[1].get(name, 0.0) for name in top]
        ax.scatter(range(len(top)), values, s=42, color=COLORS[1], edgecolor="white", linewidth=0.8, zorder=3)
    ax.set_xticks(range(len(top)), [n.replace("_", " ") for n in top], rotation=55, ha="right", rotation_mode="anchor")
    ax.tick_params(axis="x", length=0)
    ax.set(ylabel="placements", xlim=(-0.7, len(top) - 0.3))
    percent_axis(ax.yaxis)
    ax.grid(axis="y")
    notes = [
        f"{len(share)} anchors; these {len(top)} hold {100 * sum(share.get(n, 0) for n in top):.0f} % of the placements"
        for share in shares
    ]
    _legend(ax, found, notes)
    return figure


def _relations(found: Sequence[Measures]) -> Any:
    figure = new_figure(8, 4.5, title="Relation of a thing to its anchor")
    ax = figure.subplots()
    rows = [[one.figures["relations"][name] for name in RELATIONS] for one in found]
    shown = {"ontop": "on top of", "inside": "inside", "under": "under", "nextto": "next to"}
    grouped_bars(ax, rows, [shown[name] for name in RELATIONS], lambda v: f"{100 * v:.0f} %")
    percent_axis(ax.yaxis)
    ax.set_ylabel("placements")
    ax.grid(axis="y")
    _legend(ax, found, [f"{one.figures['placements']:,} placements" for one in found])
    return figure


def _contexts(found: Sequence[Measures]) -> Any:
    """Contexts of the first dataset that has any (the release has none)."""
    one = next((m for m in found if m.figures["contexts"]["placements"]), found[0])
    told, known = one.figures["contexts"], conditions(one.dataset)
    figure = new_figure(
        13,
        6.6,
        title=f"When placements hold: {told['placements']:,} of {one.figures['placements']:,} have a context "
        f"({_label(one)})",
    )
    panels = figure.subplot_mosaic([["kind", "season", "group"], ["day", "hour", "group"]], width_ratios=(1, 1, 0.9))
    seasons = [sum(s in (c.seasons or ()) for c in known) for s in SEASONS]
    days = [sum(d in (c.days or ()) for c in known) for d in range(7)]
    grouped_bars(panels["kind"], [[told["kinds"][k] for k in CONTEXT_KINDS]], CONTEXT_KINDS, "{:,.0f}".format)
    grouped_bars(panels["season"], [seasons], SEASONS, str)
    grouped_bars(panels["day"], [days], DAYS, str)
    hours = np.asarray([sum(c.hours is not None and between(h, *c.hours) for c in known) for h in range(24)])
    panels["hour"].bar(np.arange(24) + 0.5, hours, 0.92, color=COLORS[0])
    panels["hour"].set_xticks(range(0, 25, 6), [f"{h}:00" for h in range(0, 25, 6)])
    groups = Counter((c.occasion or "").partition("/")[0] for c in known)
    order = sorted(EVENT_GROUPS, key=lambda name: groups[name])
    bars = panels["group"].barh(range(len(order)), [groups[name] for name in order], 0.74, color=COLORS[0])
    panels["group"].bar_label(bars, padding=3, fontsize=9, color=GREY)
    panels["group"].set_yticks(range(len(order)), order)
    panels["group"].tick_params(axis="y", length=0)
    titles = {"kind": "Kind", "season": "Season", "day": "Day", "hour": "Time of day", "group": "Event"}
    for name, title in titles.items():
        panels[name].set_title(title)
        panels[name].grid(axis="x" if name == "group" else "y")
    return figure


def _sizes(found: Sequence[Measures]) -> Any:
    there = [(k, one) for k, one in enumerate(found) if any(one.offer.categories.values())]
    figure = new_figure(5.6 * len(there) + 2.2, 6.8, title="Habits in a knowledge base of 20 categories, by scene")
    axes = figure.subplots(1, max(1, len(there)), squeeze=False)[0]
    sizes = [v for _, one in there for v in one.offer.sizes["category"].values() if len(v)]
    longest = max([SIZEBAND[1], *(int(v.max()) for v in sizes)])
    for ax, (k, one) in zip(axes, there, strict=False):  # the axes stay empty if no scene has target categories
        scenes = [name for name, count in one.offer.categories.items() if count][::-1]
        ax.axvspan(*SIZEBAND, color=BAND)
        ax.text(sum(SIZEBAND) / 2, -1.3, "intended: 300–600", color=GREY, ha="center", va="bottom", fontsize=9)
        for mode, color in zip(MODES, (COLORS[k], LIGHT[k]), strict=True):
            values = [one.offer.sizes[mode][name] for name in scenes]
            low, high = [v.min() for v in values], [v.max() for v in values]
            ax.hlines(range(len(scenes)), low, high, color=color, linewidth=5, alpha=0.45, capstyle="round")
            ax.scatter([v.mean() for v in values], range(len(scenes)), s=34, color=color, zorder=3)
            ax.text(np.mean(values), len(scenes) - 0.1, mode, color=color, ha="center", va="bottom", fontweight="bold")
        ax.set_yticks(range(len(scenes)), scenes, fontsize=9)
        ax.tick_params(axis="y", length=0)
        ax.set(
            xlabel="habits (mean, minimum and maximum of ten draws)",
            xlim=(0, longest * 1.04),
            ylim=(-1.4, len(scenes) + 0.6),
        )
        ax.set_title(_label(one), pad=12)
        ax.grid(axis="x")
    return figure


def _retrieval(found: Sequence[Measures]) -> Any:
    figure = new_figure(
        11, 5.4, title="Retrieval: share of a target's habits among the first k (MiniLM, the paper's query)"
    )
    axes = figure.subplots(1, 2, sharey=True)
    k = np.arange(1, LONGEST + 1)
    for ax, mode in zip(axes, MODES, strict=True):
        for color, one in zip(COLORS, found, strict=False):
            result = one.retrieval[mode]
            ax.plot(k, result.recall, color=color, linewidth=2.4, label=f"{_label(one)}, all own habits")
            if result.supporting is not None:
                label = f"{_label(one)}, habits that name a place"
                ax.plot(k, result.supporting, color=color, linewidth=2.2, linestyle=(0, (4, 2)), label=label)
        ax.axvline(20, color=GREY, linewidth=1, linestyle=":")
        ax.text(20.6, 0.975, "agents get 20", color=GREY, fontsize=9, va="top")
        sizes = ", ".join(f"{one.retrieval[mode].size:.0f}" for one in found)
        ax.set_title(f"{mode} mode ({sizes} habits)")
        ax.set(xlabel="k", xlim=(0, LONGEST), ylim=(0, 1))
        ax.grid()
        percent_axis(ax.yaxis)
    axes[0].set_ylabel("recall")
    axes[1].legend(loc="lower right")
    return figure


_PLOTS: dict[str, Callable[[Sequence[Measures]], Any]] = {
    "words": _words,
    "entries": _entries,
    "anchors": _anchors,
    "relations": _relations,
    "contexts": _contexts,
    "knowledge_bases": _sizes,
    "retrieval": _retrieval,
}
