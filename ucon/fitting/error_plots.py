"""Pictures of a detector's errors: recall, scores, confusions, and whether the fitted chances hold."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from ucon.core.errors import ConfigError, unknown_name
from ucon.evaluation.figures.plotting import (
    COLORS,
    GREY,
    INK,
    STYLE,
    new_figure,
    require_matplotlib,
    save_png,
)
from ucon.fitting.reliability import Reliability
from ucon.perception.detectors.base import vocabulary
from ucon.perception.errors.model import DetectorErrors

#: Distances in metres of the recall curves, and their shades.
_AWAY_M: Final = {1.0: "#0b4f4a", 2.0: "#0f766e", 4.0: "#58a79f", 8.0: "#a9d5d0"}
#: Number of names in the confusion picture.
_NAMES: Final = 14


def draw_errors(errors: DetectorErrors, thing: str, folder: Path, held: Reliability | None = None) -> list[Path]:
    """Write the pictures of a detector's errors into a folder.

    Args:
        errors: of the detector.
        thing: a catalogue name; what it is confused with is shown.
        folder: for the PNG files.
        held: how well the fitted chances hold in held-out walks; None leaves that picture out.

    Returns:
        The files, in order.

    Raises:
        ConfigError: matplotlib is missing, or no such thing.
    """
    require_matplotlib()
    if thing not in vocabulary():
        raise ConfigError(unknown_name("thing", thing, vocabulary()))
    from matplotlib import rc_context

    pictures: dict[str, Callable[[], Any]] = {
        "recall": lambda: _recall(errors),
        "scores": lambda: _scores(errors),
        "confusions": lambda: _confusions(errors, thing),
    }
    if held is not None:
        pictures["reliability"] = lambda: _reliability(errors, held)
    with rc_context(STYLE):
        for name, draw in pictures.items():
            save_png(draw(), folder / f"{name}.png")
    return [folder / f"{name}.png" for name in pictures]


def _recall(errors: DetectorErrors) -> Any:
    """Chance that a thing is found by its pixels, one curve for each distance."""
    figure = new_figure(7.0, 4.6, f"{errors.detector}: how often a thing that shows whole is found")
    axes = figure.gca()
    pixels = np.geomspace(4.0, 4000.0, 120)
    for away_m, color in _AWAY_M.items():
        chance = errors.found(pixels, np.full_like(pixels, away_m), np.ones_like(pixels))
        axes.plot(pixels, 100 * chance, color=color, lw=2.2, label=f"{away_m:g} m away")
    third = errors.found(pixels, np.full_like(pixels, 2.0), np.full_like(pixels, 1 / 3))
    axes.plot(pixels, 100 * third, color=COLORS[1], lw=2.0, ls="--", label="2 m away, a third of it shows")
    axes.set(xscale="log", xlabel="pixels in a 128 x 128 view of 90 degrees", ylim=(0, 100), xlim=(4, 4000))
    axes.set_ylabel("found (%)")
    axes.grid(axis="y")
    axes.legend(loc="lower right")
    return figure


def _scores(errors: DetectorErrors) -> Any:
    """How much likelier a score is for a right box than for a wrong one."""
    figure = new_figure(7.0, 4.2, f"{errors.detector}: what a score tells")
    axes = figure.gca()
    scores = np.linspace(errors.score_knots[0], errors.score_knots[-1], 100)
    axes.plot(scores, np.exp([errors.evidence(float(s)) for s in scores]), color=COLORS[0], lw=2.2)
    axes.axhline(1.0, color=GREY, lw=1.0, ls=":")
    axes.set(yscale="log", xlabel="score", ylabel="right box : wrong box")
    axes.grid(axis="y")
    return figure


def _confusions(errors: DetectorErrors, thing: str) -> Any:
    """The wrong names that a thing is called by most often."""
    figure = new_figure(7.0, 5.0, f"{errors.detector}: what a {thing.replace('_', ' ')} is called, if not its own name")
    axes = figure.gca()
    names, chance = vocabulary(), 100 * np.exp(errors.called[vocabulary().index(thing)])
    order = np.argsort(-chance, kind="stable")[:_NAMES][::-1]
    axes.barh([names[k].replace("_", " ") for k in order], chance[order], color=COLORS[0], height=0.7)
    axes.set_xlabel(f"of wrong names (%); {100 * errors.right:.0f} % of what is found has the right one")
    axes.grid(axis="x")
    axes.tick_params(axis="y", length=0)
    return figure


def _reliability(errors: DetectorErrors, held: Reliability) -> Any:
    """Predicted against observed share of things found, in held-out walks."""
    figure = new_figure(5.6, 5.4, f"{errors.detector}: in homes held out")
    axes = figure.gca()
    axes.plot([0, 100], [0, 100], color=GREY, lw=1.0, ls=":")
    size = 20 + 180 * held.looks / held.looks.max()
    axes.scatter(100 * held.predicted, 100 * held.observed, s=size, color=COLORS[0], zorder=3)
    axes.text(4, 92, f"calibration error {held.error:.3f}\n{held.looks.sum():,} looks", color=INK, va="top")
    axes.set(xlim=(0, 100), ylim=(0, 100), xlabel="predicted to be found (%)", ylabel="found (%)")
    axes.grid()
    return figure
