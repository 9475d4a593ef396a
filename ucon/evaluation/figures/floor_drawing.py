"""Draws the floor of a home from above: rooms, openings, and the furniture in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.evaluation.figures.plotting import GREY
from ucon.sim.house import House

FLOOR: Final = "#f4f1ea"
_THING, _THING_EDGE, _WALL = "#ddd6c8", "#b8ad9a", "#4b4a48"
_UNSEEN: Final = ("door", "room_light", "carpet")
#: Things that hang higher than this are left out, metres.
_HIGHEST_M: Final = 1.2


@dataclass(frozen=True)
class Floor:
    """What is drawn of a home.

    Attributes:
        house: the home.
        boxes: (n, 6) boxes of its things, then of those placed in it, metres.
        names: of the rooms.
    """

    house: House
    boxes: NDArray[np.float64]
    names: tuple[str, ...]


def draw_floor(axes: Any, floor: Floor) -> None:
    """Draw a home from above.

    Args:
        axes: matplotlib axes.
        floor: what is drawn.
    """
    from matplotlib.patches import Rectangle

    for room, name in zip(floor.house.spec.rooms, floor.names, strict=True):
        x0, y0, x1, y1 = room.rect
        axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, facecolor=FLOOR, edgecolor=_WALL, linewidth=2.5))
        axes.text(x0 + 0.12, y1 - 0.12, name, va="top", size=7, color=GREY)
    for hole in floor.house.spec.openings:
        ends = np.array([(hole.coord, at) if hole.axis == 0 else (at, hole.coord) for at in (hole.lo, hole.hi)])
        axes.plot(*ends.T, color=FLOOR, linewidth=3.5, solid_capstyle="butt")
    for item, box in zip(floor.house.spec.items, floor.boxes, strict=False):
        if item.category not in _UNSEEN and np.isfinite(box).all() and box[2] < _HIGHEST_M:
            size = (box[3] - box[0], box[4] - box[1])
            axes.add_patch(Rectangle((box[0], box[1]), *size, facecolor=_THING, edgecolor=_THING_EDGE, linewidth=0.6))
    axes.set_aspect("equal")
    axes.set_axis_off()
