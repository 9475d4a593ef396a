"""Pictures of a habit dataset for slides and papers, one or two datasets in each."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ucon.core.errors import ConfigError
from ucon.core.files import write_atomic
from ucon.evaluation.habit_homes import LONGEST
from ucon.evaluation.habit_places import KINDS, anchor_shares, conditions
from ucon.evaluation.habit_text import word_counts
from ucon.habits import RELATIONS
from ucon.habits.contexts import DAYS, EVENT_GROUPS, SEASONS
from ucon.habits.knowledge import MODES

if TYPE_CHECKING:
    from ucon.evaluation.habit_statistics import Measures

_COLORS = ("#0f766e", "#d97706")
_LIGHT = ("#7cc4bd", "#f2c58b")
_INK, _GREY, _BAND = "#1f2937", "#6b7280", "#eef2f4"
_DPI = 160
_TOP_ANCHORS = 40
#: Knowledge bases of the default mode are meant to lie here (the paper's are above 300).
SIZE_BAND = (300, 600)
_STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "text.color": _INK,
    "axes.labelcolor": _INK,
    "axes.edgecolor": "#9ca3af",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "grid.color": "#e5e7eb",
    "xtick.color": _GREY,
    "ytick.color": _GREY,
    "xtick.labelcolor": _INK,
    "ytick.labelcolor": _INK,
    "legend.frameon": True,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.9,
}


def require_matplotlib() -> None:
    """Raise :class:`ConfigError` where matplotlib, an optional extra, is missing."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise ConfigError("plots need matplotlib, which is not installed: pip install 'ucon[plots]'") from None


def draw_plots(found: Sequence[Measures], folder: Path) -> list[Path]:
    """Write all pictures of one or two datasets into ``folder``; the files, in order.

    Raises:
        ConfigError: matplotlib is missing.
    """
    require_matplotlib()
    from matplotlib import rc_context

    paths = []
    with rc_context(_STYLE):
        for name, draw in _PLOTS.items():
            buffer = io.BytesIO()
            draw(found).savefig(buffer, format="png", dpi=_DPI, facecolor="white")
            paths.append(folder / f"{name}.png")
            write_atomic(paths[-1], buffer.getvalue())
    return paths


def _label(one: Measures) -> str:
    name = one.dataset.name
    return "habit book" if name == "book" else "official release" if name.startswith("official") else name


def _figure(width: float = 10.0, height: float = 5.0, title: str = "") -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.1, wspace=0.04, hspace=0.06)
    figure.suptitle(title, x=0.012, ha="left", fontsize=15, fontweight="bold")
    return figure


def _percent_axis(axis: Any) -> None:
    from matplotlib.ticker import PercentFormatter

    axis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))


def _bars(ax: Any, rows: Sequence[Sequence[float]], names: Sequence[str], label: Callable[[float], str]) -> None:
    """Grouped vertical bars, a series of ``rows`` each, with their values on top."""
    width = 0.8 / len(rows)
    for k, values in enumerate(rows):
        x = np.arange(len(values)) + (k - (len(rows) - 1) / 2) * width
        bars = ax.bar(x, values, width * 0.94, color=_COLORS[k])
        ax.bar_label(bars, [label(v) for v in values], padding=2, fontsize=9, color=_GREY)
    ax.set_xticks(np.arange(len(names)), names)
    ax.tick_params(axis="x", length=0)
    ax.margins(y=0.12)


def _legend(ax: Any, found: Sequence[Measures], notes: Sequence[str], loc: str = "upper right") -> None:
    """Coloured names of the datasets, each with a note."""
    from matplotlib.patches import Patch

    marks = [
        Patch(color=_COLORS[k], label=f"{_label(one)}: {note}" if note else _label(one))
        for k, (one, note) in enumerate(zip(found, notes, strict=True))
    ]
    ax.legend(handles=marks, loc=loc, handlelength=1.0, handleheight=1.0)


def _words(found: Sequence[Measures]) -> Any:
    figure = _figure(title="Words a habit")
    ax = figure.subplots()
    lengths = [word_counts(one.dataset) for one in found]
    for color, counts in zip(_COLORS, lengths, strict=False):
        y = np.bincount(counts) / len(counts)
        edges = np.arange(len(y) + 1) - 0.5
        ax.stairs(y, edges, fill=True, color=color, alpha=0.28)
        ax.stairs(y, edges, color=color, linewidth=2)
    _percent_axis(ax.yaxis)
    last = max(float(np.percentile(counts, 99.9)) for counts in lengths)
    ax.set(xlabel="words", ylabel="habits", xlim=(1.5, last + 0.5))
    ax.margins(y=0.12)
    ax.grid(axis="y")
    notes = [
        f"mean {one.figures['words_per_habit']:.1f}, 5–95 % from {one.figures['words_per_habit_p5']} "
        f"to {one.figures['words_per_habit_p95']}"
        for one in found
    ]
    _legend(ax, found, notes)
    return figure


def _entries(found: Sequence[Measures]) -> Any:
    figure = _figure(title="Households (entries) a target category")
    ax = figure.subplots()
    counts = [list(Counter(e.category for e in one.dataset.entries).values()) for one in found]
    last = 12 if max(map(max, counts)) > 12 else max(map(max, counts))
    rows = [np.bincount(np.minimum(c, last), minlength=last + 1)[1:] / len(c) for c in counts]
    names = [str(n) for n in range(1, last)] + [f"{last}+" if max(map(max, counts)) > last else str(last)]
    _bars(ax, [list(row) for row in rows], names, lambda v: f"{100 * v:.0f}" if v >= 0.005 else "")
    _percent_axis(ax.yaxis)
    ax.set(xlabel="entries", ylabel="categories")
    ax.grid(axis="y")
    notes = [f"{len(c)} categories, mean {np.mean(c):.1f}, most {max(c)}" for c in counts]
    _legend(ax, found, notes)
    return figure


def _anchors(found: Sequence[Measures]) -> Any:
    figure = _figure(13, 6, title=f"Where things are kept: the {_TOP_ANCHORS} most frequent anchors")
    ax = figure.subplots()
    shares = [anchor_shares(one.dataset) for one in found]
    top = list(shares[0])[:_TOP_ANCHORS]
    ax.bar(range(len(top)), [shares[0][name] for name in top], 0.74, color=_COLORS[0])
    if len(found) > 1:
        values = [shares[1].get(name, 0.0) for name in top]
        ax.scatter(range(len(top)), values, s=42, color=_COLORS[1], edgecolor="white", linewidth=0.8, zorder=3)
    ax.set_xticks(range(len(top)), [n.replace("_", " ") for n in top], rotation=55, ha="right", rotation_mode="anchor")
    ax.tick_params(axis="x", length=0)
    ax.set(ylabel="placements", xlim=(-0.7, len(top) - 0.3))
    _percent_axis(ax.yaxis)
    ax.grid(axis="y")
    notes = [
        f"{len(share)} anchors; these {len(top)} bear {100 * sum(share.get(n, 0) for n in top):.0f} % of the placements"
        for share in shares
    ]
    _legend(ax, found, notes)
    return figure


def _relations(found: Sequence[Measures]) -> Any:
    figure = _figure(8, 4.5, title="Relation of a thing to its anchor")
    ax = figure.subplots()
    rows = [[one.figures["relations"][name] for name in RELATIONS] for one in found]
    shown = {"ontop": "on top of", "inside": "inside", "under": "under", "nextto": "next to"}
    _bars(ax, rows, [shown[name] for name in RELATIONS], lambda v: f"{100 * v:.0f} %")
    _percent_axis(ax.yaxis)
    ax.set_ylabel("placements")
    ax.grid(axis="y")
    _legend(ax, found, [f"{one.figures['placements']:,} placements" for one in found], "upper left")
    return figure


def _contexts(found: Sequence[Measures]) -> Any:
    """Of the first dataset with contexts; the release has none."""
    one = next((m for m in found if m.figures["contexts"]["placements"]), found[0])
    told, known = one.figures["contexts"], conditions(one.dataset)
    figure = _figure(
        13,
        6.6,
        title=f"When placements hold: {told['placements']:,} of {one.figures['placements']:,} have a context "
        f"({_label(one)})",
    )
    panels = figure.subplot_mosaic([["kind", "season", "group"], ["day", "hour", "group"]], width_ratios=(1, 1, 0.9))
    seasons = [sum(s in (c.seasons or ()) for c in known) for s in SEASONS]
    days = [sum(d in (c.days or ()) for c in known) for d in range(7)]
    _bars(panels["kind"], [[told["kinds"][k] for k in KINDS]], KINDS, "{:,.0f}".format)
    _bars(panels["season"], [seasons], SEASONS, str)
    _bars(panels["day"], [days], DAYS, str)
    hours = np.asarray([sum(c.hours is not None and _covers(c.hours, h) for c in known) for h in range(24)])
    panels["hour"].bar(np.arange(24) + 0.5, hours, 0.92, color=_COLORS[0])
    panels["hour"].set_xticks(range(0, 25, 6), [f"{h}:00" for h in range(0, 25, 6)])
    groups = Counter((c.occasion or "").partition("/")[0] for c in known)
    order = sorted(EVENT_GROUPS, key=lambda name: groups[name])
    bars = panels["group"].barh(range(len(order)), [groups[name] for name in order], 0.74, color=_COLORS[0])
    panels["group"].bar_label(bars, padding=3, fontsize=9, color=_GREY)
    panels["group"].set_yticks(range(len(order)), order)
    panels["group"].tick_params(axis="y", length=0)
    titles = {"kind": "Kind", "season": "Season", "day": "Day", "hour": "Time of day", "group": "Event"}
    for name, title in titles.items():
        panels[name].set_title(title)
        panels[name].grid(axis="x" if name == "group" else "y")
    return figure


def _covers(hours: tuple[int, int], hour: int) -> bool:
    start, end = hours
    return start <= hour < end if start < end else hour >= start or hour < end


def _sizes(found: Sequence[Measures]) -> Any:
    there = [(k, one) for k, one in enumerate(found) if one.offer.categories]
    figure = _figure(5.6 * len(there) + 2.2, 6.8, title="Habits in a knowledge base of 20 categories, by scene")
    axes = figure.subplots(1, len(there), squeeze=False, sharex=True)[0]
    for ax, (k, one) in zip(axes, there, strict=True):
        scenes = list(one.offer.categories)[::-1]
        ax.axvspan(*SIZE_BAND, color=_BAND)
        ax.text(sum(SIZE_BAND) / 2, -1.3, "meant to be 300–600", color=_GREY, ha="center", va="bottom", fontsize=9)
        for mode, color in zip(MODES, (_COLORS[k], _LIGHT[k]), strict=True):
            values = [one.offer.sizes[mode][name] for name in scenes]
            low, high = [v.min() for v in values], [v.max() for v in values]
            ax.hlines(range(len(scenes)), low, high, color=color, linewidth=5, alpha=0.45, capstyle="round")
            ax.scatter([v.mean() for v in values], range(len(scenes)), s=34, color=color, zorder=3)
            ax.text(np.mean(values), len(scenes) - 0.1, mode, color=color, ha="center", va="bottom", fontweight="bold")
        ax.set_yticks(range(len(scenes)), scenes, fontsize=9)
        ax.tick_params(axis="y", length=0)
        ax.set(xlabel="habits (mean, least and most of ten draws)", xlim=(0, None), ylim=(-1.4, len(scenes) + 0.6))
        ax.set_title(_label(one), pad=12)
        ax.grid(axis="x")
    return figure


def _retrieval(found: Sequence[Measures]) -> Any:
    figure = _figure(
        11, 5.4, title="Retrieval: share of a target's habits among the first k (MiniLM, the paper's query)"
    )
    axes = figure.subplots(1, 2, sharey=True)
    k = np.arange(1, LONGEST + 1)
    for ax, mode in zip(axes, MODES, strict=True):
        for color, one in zip(_COLORS, found, strict=False):
            result = one.retrieval[mode]
            ax.plot(k, result.recall, color=color, linewidth=2.4, label=f"{_label(one)}, all own habits")
            if result.supporting is not None:
                label = f"{_label(one)}, habits that tell a place"
                ax.plot(k, result.supporting, color=color, linewidth=2.2, linestyle=(0, (4, 2)), label=label)
        ax.axvline(20, color=_GREY, linewidth=1, linestyle=":")
        ax.text(20.6, 0.975, "agents get 20", color=_GREY, fontsize=9, va="top")
        sizes = ", ".join(f"{one.retrieval[mode].size:.0f}" for one in found)
        ax.set_title(f"{mode} mode ({sizes} habits)")
        ax.set(xlabel="k", xlim=(0, LONGEST), ylim=(0, 1))
        ax.grid()
        _percent_axis(ax.yaxis)
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
