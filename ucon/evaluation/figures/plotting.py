"""Style of the project's plots: colours, figures, bars. matplotlib is an optional extra, imported when needed."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ucon.core.errors import ConfigError
from ucon.core.files import write_atomic

COLORS = ("#0f766e", "#d97706")
LIGHT = ("#7cc4bd", "#f2c58b")
INK, GREY, BAND = "#1f2937", "#6b7280", "#eef2f4"
_DPI = 160
#: Position of legends: above the axes.
ABOVE: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.01, 1.0), "handlelength": 1.0, "handleheight": 1.0}

STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#9ca3af",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.titlelocation": "left",
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "grid.color": "#e5e7eb",
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": True,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.9,
}


def require_matplotlib() -> None:
    """Raise :class:`ConfigError` where matplotlib, an optional extra, is missing."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise ConfigError("plots need matplotlib, which is not installed: pip install 'ucon-nav[plots]'") from None


def save_png(figure: Any, path: Path) -> None:
    """Write a figure as PNG, atomically."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DPI, facecolor="white")
    write_atomic(path, buffer.getvalue())


def new_figure(width: float = 10.0, height: float = 5.0, title: str = "") -> Any:
    """A new figure with its title at the left.

    Args:
        width: in inches.
        height: in inches.
        title: text.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    layout = ConstrainedLayoutEngine(w_pad=0.12, h_pad=0.1, wspace=0.04, hspace=0.06)
    figure = Figure(figsize=(width, height), layout=layout)
    figure.suptitle(title, x=0.012, ha="left", fontsize=15, fontweight="bold")
    return figure


def percent_axis(axis: Any) -> None:
    """Show the shares on an axis as per cent."""
    from matplotlib.ticker import PercentFormatter

    axis.set_major_formatter(PercentFormatter(1.0, decimals=0, symbol=" %"))


def grouped_bars(ax: Any, rows: Sequence[Sequence[float]], names: Sequence[str], label: Callable[[float], str]) -> None:
    """Draw grouped vertical bars with their values on top.

    Args:
        ax: axes.
        rows: values of each series.
        names: of the groups.
        label: text of a value.
    """
    width = 0.8 / len(rows)
    for k, values in enumerate(rows):
        x = np.arange(len(values)) + (k - (len(rows) - 1) / 2) * width
        bars = ax.bar(x, values, width * 0.94, color=COLORS[k])
        ax.bar_label(bars, [label(v) for v in values], padding=2, fontsize=9, color=GREY)
    ax.set_xticks(np.arange(len(names)), names)
    ax.tick_params(axis="x", length=0)
    ax.margins(y=0.12)
