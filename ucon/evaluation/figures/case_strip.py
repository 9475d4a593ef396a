"""Draws the searches of one case as a figure: a strip of camera frames at the waypoints of each, and maps below.

For people only, since it shows privileged facts.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.evaluation.figures.floor_drawing import Floor, draw_floor
from ucon.evaluation.figures.plotting import COLORS, INK, STYLE, require_matplotlib, save_png

#: Largest number of waypoints in a strip.
MOST_WAYPOINTS: Final = 6
_STAR: Final = "#d63c30"
_WIDTH_IN: Final = 13.0
_LINE: Final = 150


@dataclass(frozen=True)
class Waypoint:
    """Where a search decided what to do next, or ended.

    Attributes:
        step: number of actions before it.
        xy: where the robot stood, world metres.
        frame: (H, W, 3) uint8, what its camera saw.
        goal: where it headed next, in words.
    """

    step: int
    xy: tuple[float, float]
    frame: NDArray[np.uint8]
    goal: str


@dataclass(frozen=True)
class Strip:
    """One search.

    Attributes:
        title: the agent, what it was given, and how the search ended.
        waypoints: in order, at most :data:`MOST_WAYPOINTS`.
        path_xy: (n, 2) world metres.
    """

    title: str
    waypoints: tuple[Waypoint, ...]
    path_xy: NDArray[np.float64]


def chosen_steps(decided: Sequence[int], end: int, most: int = MOST_WAYPOINTS) -> list[int]:
    """Steps of the waypoints that are shown: the first, the last, and evenly spaced decisions between them.

    Args:
        decided: steps of the decisions, ascending.
        end: number of steps of the search.
        most: largest number of waypoints, the first and the last included.
    """
    between = [step for step in dict.fromkeys(decided) if 0 < step < end]
    room = max(most - 2, 0)
    if len(between) > room:
        between = [between[round(k)] for k in np.linspace(0, len(between) - 1, room)] if room else []
    return list(dict.fromkeys([0, *between, end]))


def draw_case(
    title: str,
    caption: str,
    strips: Sequence[Strip],
    floor: Floor,
    target: int,
    path: Path,
) -> None:
    """Draw a case into a PNG.

    Args:
        title: what is searched for, and where it is.
        caption: the habits that say so.
        strips: at most two searches.
        floor: the home.
        target: index of the target in the floor's boxes.
        path: the file.

    Raises:
        ConfigError: matplotlib is missing.
    """
    require_matplotlib()
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    frame_in = _WIDTH_IN / MOST_WAYPOINTS
    spans = np.ptp(np.array([room.rect for room in floor.house.spec.rooms]).reshape(-1, 2), axis=0)
    map_in = min(_WIDTH_IN / len(strips) * float(spans[1] / spans[0]), 4.6)
    words = textwrap.wrap(caption, _LINE)
    heights = [*[frame_in + 0.5] * len(strips), map_in]
    with rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH_IN, sum(heights) + 0.7 + 0.24 * len(words)), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left", weight="bold", color=INK)
        figure.supxlabel("\n".join(words), x=0.01, ha="left", size=10.5, style="italic", color=INK)
        parts: Any = figure.subfigures(len(strips) + 1, 1, height_ratios=heights)
        for strip, color, part in zip(strips, COLORS, parts[:-1], strict=False):
            _draw_strip(part, strip, color)
        maps = parts[-1].subplots(1, len(strips), squeeze=False)[0]
        for strip, color, axes in zip(strips, COLORS, maps, strict=False):
            _draw_map(axes, strip, color, floor, target)
        path.parent.mkdir(parents=True, exist_ok=True)
        save_png(figure, path)


def _draw_strip(part: Any, strip: Strip, color: str) -> None:
    part.suptitle(strip.title, x=0.01, ha="left", size=11, color=color, weight="bold")
    all_axes = part.subplots(1, MOST_WAYPOINTS)
    for axes in all_axes:
        axes.set_axis_off()
    for number, (axes, point) in enumerate(zip(all_axes, strip.waypoints, strict=False), 1):
        axes.imshow(point.frame)
        axes.text(
            0.04, 0.94, str(number), transform=axes.transAxes, va="top", color="white", size=10, weight="bold",
            bbox={"boxstyle": "circle,pad=0.25", "facecolor": color, "edgecolor": "white"},
        )  # fmt: skip
        below = "\n".join(textwrap.wrap(f"step {point.step}: {point.goal}", 30)[:2])
        axes.text(0.0, -0.03, below, transform=axes.transAxes, va="top", size=8, color=INK)


def _draw_map(axes: Any, strip: Strip, color: str, floor: Floor, target: int) -> None:
    draw_floor(axes, floor)
    axes.plot(*strip.path_xy.T, color=color, linewidth=1.8, solid_joinstyle="round")
    middle = (floor.boxes[target, :2] + floor.boxes[target, 3:5]) / 2
    axes.plot(*middle, marker="*", markersize=15, color=_STAR, markeredgecolor="white", linestyle="none", zorder=5)
    for number, point in enumerate(strip.waypoints, 1):
        axes.plot(*point.xy, marker="o", markersize=11, color=color, markeredgecolor="white", zorder=6)
        axes.text(*point.xy, str(number), ha="center", va="center_baseline", size=7, color="white", zorder=7)
