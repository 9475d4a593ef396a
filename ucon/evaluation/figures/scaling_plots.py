"""Pictures of cost against size: of ranking a knowledge base, of a step in homes with more things and more rooms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

from ucon.evaluation.bench_scaling import QueryCost, StepCost
from ucon.evaluation.figures.plotting import STYLE, new_figure, require_matplotlib, save_png

_COLORS: Final = ("#0f766e", "#d97706", "#5b4bb7", "#b3261e")
_BOUND_MS: Final = 50.0
"""Time limit for a query at 100,000 sentences."""


def plot_scaling(queries: Sequence[QueryCost], steps: Sequence[StepCost], folder: Path) -> list[Path]:
    """Draw ``scaling_sentences.png``, ``scaling_things.png`` and ``scaling_rooms.png``.

    Args:
        queries: cost of queries, at least one.
        steps: cost of steps, at least one.
        folder: is created if missing.

    Returns:
        The files written.

    Raises:
        ConfigError: matplotlib is not installed.
    """
    require_matplotlib()
    import matplotlib

    drawn: dict[str, Callable[[], Any]] = {
        "scaling_sentences.png": lambda: _sentences(queries),
        "scaling_things.png": lambda: _steps(steps, [cost.things for cost in steps], "things"),
        "scaling_rooms.png": lambda: _steps(steps, [cost.rooms for cost in steps], "rooms"),
    }
    folder.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        for name, draw in drawn.items():
            save_png(draw(), folder / name)
    return [folder / name for name in drawn]


def _sentences(costs: Sequence[QueryCost]) -> Any:
    """One line per retriever, both axes logarithmic."""
    figure = new_figure(6, 3.8, "Time per query, by number of sentences")
    ax = figure.subplots()
    for k, name in enumerate(dict.fromkeys(cost.retriever for cost in costs)):
        of_it = [cost for cost in costs if cost.retriever == name]
        at, ms = [cost.sentences for cost in of_it], [cost.query_ms for cost in of_it]
        ax.loglog(at, ms, color=_COLORS[k % len(_COLORS)], marker="o", markersize=4, linewidth=1.6, label=name)
    ax.axhline(_BOUND_MS, color="#9ca3af", linestyle="--", linewidth=1)
    ax.annotate(f"{_BOUND_MS:.0f} ms", (100, _BOUND_MS), (0, -4), textcoords="offset points", va="top", fontsize=9)
    ax.set(xlabel="sentences in the knowledge base", ylabel="milliseconds")
    ax.grid()
    ax.legend(fontsize=9)
    return figure


def _steps(costs: Sequence[StepCost], sizes: Sequence[int], what: str) -> Any:
    """One point per home; both axes start at zero."""
    from matplotlib.ticker import MaxNLocator

    figure = new_figure(6, 3.4, f"Time per step with images, by number of {what}")
    ax = figure.subplots()
    ax.scatter(sizes, [cost.step_ms for cost in costs], color=_COLORS[0], s=28)
    ax.margins(0.06, 0.15)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(xlim=(0, None), ylim=(0, None), xlabel=f"{what} in the home", ylabel="milliseconds")
    ax.grid(axis="y")
    return figure
