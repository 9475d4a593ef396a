"""Draws a home as a figure: from above, and what a camera sees of each room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.evaluation.figures.floor_drawing import Floor, draw_floor
from ucon.evaluation.figures.plotting import GREY, STYLE, require_matplotlib, save_png
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState

#: Height of the camera, as on the robot's rods; a wide view, so that a room can be recognised.
CAMERA_M: Final = 0.9
_FOV_DEG: Final = 80.0
_FRAME_PX: Final = 320
_PITCH_DEG: Final = -8.0
_ROWS: Final = 2
_TILE_IN: Final = 2.1


def draw_home(house: House, arrangement: Arrangement, names: Sequence[str], title: str, path: Path) -> None:
    """Draw a home into a PNG.

    Args:
        house: the home.
        arrangement: what was put into it.
        names: of the rooms.
        title: above the figure.
        path: the file.

    Raises:
        ConfigError: matplotlib is missing.
    """
    require_matplotlib()
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    world = SceneState(house, arrangement)
    frames = [(name, frame) for name, frame in zip(names, _rooms_seen(house, world), strict=True) if frame is not None]
    columns = -(-len(frames) // _ROWS)
    with rc_context(STYLE):
        figure = Figure(figsize=(_TILE_IN * (columns + 2.2), _TILE_IN * _ROWS + 0.6), layout="constrained")
        figure.suptitle(title, x=0.01, ha="left", weight="bold")
        left, right = figure.subfigures(1, 2, width_ratios=(2.2, columns))
        draw_floor(left.subplots(), Floor(house, world.boxes, tuple(names)))
        tiles = right.subplots(_ROWS, columns, squeeze=False).ravel()
        for axes in tiles:
            axes.set_axis_off()
        for axes, (room, frame) in zip(tiles, frames, strict=False):
            axes.imshow(frame)
            axes.set_title(room, size=8, color=GREY, weight="normal")
        path.parent.mkdir(parents=True, exist_ok=True)
        save_png(figure, path)


def _rooms_seen(house: House, world: SceneState) -> list[NDArray[np.uint8] | None]:
    """Each room as seen from its free node that is farthest from its middle; None for a room without free nodes."""
    renderer = RasterRenderer(_FRAME_PX, _FRAME_PX, _FOV_DEG)
    renderer.load(house, world.arrangement)
    found: list[NDArray[np.uint8] | None] = []
    for number, room in enumerate(house.spec.rooms):
        middle = np.array([(room.rect[0] + room.rect[2]) / 2, (room.rect[1] + room.rect[3]) / 2])
        cells = np.argwhere(world.free & (house.grid.room == number))
        if not len(cells):
            found.append(None)
            continue
        nodes = np.array([house.grid.xy((int(i), int(j))) for i, j in cells])
        x, y = nodes[np.hypot(*(nodes - middle).T).argmax()].tolist()
        heading = math.atan2(middle[1] - y, middle[0] - x) / (math.pi / 2)
        frame = np.empty((_FRAME_PX, _FRAME_PX, 3), np.uint8)
        renderer.render(x, y, CAMERA_M, heading, _PITCH_DEG, rgb=frame)
        found.append(frame)
    return found
