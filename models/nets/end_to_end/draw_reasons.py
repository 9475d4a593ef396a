"""Draws a step of the end-to-end habit policy: its map, its belief, where it goes and why."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from models.nets.end_to_end.ego_view import CELL_M
from models.nets.end_to_end.floor_memory import HALF, REACH, SIZE
from models.nets.end_to_end.reasons import Reasons
from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.perception.drawing.map_picture import FLOOR_COLOUR, OPENED, PATH, TALL, TARGET, UNKNOWN, Image, draw_agent
from ucon.perception.drawing.overlay import FAINT, GOAL, WARM, Line, belief_lines, habit_lines, map_room, page, words
from ucon.search.thoughts import BelievedThing
from ucon.task.actions import Action

_MOST_CELL_PX: Final = 10
#: Width, in cells, of unknown space shown around explored space.
_RIM: Final = 2
#: Actions above this probability are listed.
_LIKELY: Final = 0.05
#: A goal within this distance of the seen target, in metres, counts as going to the target.
_BY_M: Final = 2.0
#: Goals with at least this share of the highest probability are shown, even outside explored space.
_GLOW: Final = 0.05
#: Most cells that :func:`believed_cells` returns.
_MOST_CELLS: Final = 24

Layers = dict[str, NDArray[np.uint8]]
"""Layers of the map memory by name, (SIZE, SIZE) each; see :func:`models.nets.end_to_end.floor_memory.layers`."""


def draw_reasons(
    why: Reasons, target: str, layers: Layers, pose: tuple[int, int, int], height: int = 384, width: int = 384
) -> Image:
    """Draw one step of one episode.

    Above is the map memory: warmer cells have more belief, bluer cells are more probable goals, a ring marks the most
    probable one. Below are the belief, the likely actions, and the habits that speak most for the thing that the agent
    goes to.

    Args:
        why: reasons of that step.
        target: category.
        layers: the map memory after the step.
        pose: cell (i, j) relative to the start, and heading in quarter turns.
        height: of the picture, in pixels.
        width: of the picture, in pixels.

    Returns:
        (height, width, 3) uint8.
    """
    places = [(anchor, relation, p) for anchor, relation, p in why.belief[:3]]
    lines = [*belief_lines(places, width), *_intention_lines(why, target, layers), *habit_lines(why.habits, width)]
    return page(_map(why, layers, pose, *map_room(height, width)), lines, height, width)


def believed_cells(layers: Layers) -> tuple[BelievedThing, ...]:
    """The cells of the map memory with the most belief, at most 24, and their shares of the map's belief, decreasing.

    Args:
        layers: the map memory.
    """
    belief = (layers["most"].astype(float) / 255) ** 2
    most = np.argsort(-belief, axis=None, kind="stable")[:_MOST_CELLS]
    found = []
    for i, j in zip(*np.unravel_index(most, belief.shape), strict=True):
        if belief[i, j] > 0:
            x, y = _metres(int(i), int(j))
            box = (x - CELL_M / 2, y - CELL_M / 2, x + CELL_M / 2, y + CELL_M / 2)
            found.append(BelievedThing("a cell of its map", box, float(belief[i, j] / belief.sum())))
    return tuple(found)


def _intention_lines(why: Reasons, target: str, layers: Layers) -> list[Line]:
    at = _target_at(layers)
    if at is not None and np.hypot(at[0] - why.goal_xy[0], at[1] - why.goal_xy[1]) < _BY_M:
        where = f"the {words(target)}, which it saw,"
    else:
        where = f"the {words(why.thing)}" if why.thing else "unexplored space"
    likely = sorted(enumerate(why.actions), key=lambda action: -action[1])[:3]
    said = ", ".join(f"{words(Action(number).name.lower())} {p:.0%}" for number, p in likely if p > _LIKELY)
    return [Line(f"goes to: {where} {why.goal_p:.0%}", GOAL), Line(f"likely actions: {said}", FAINT)]


def _target_at(layers: Layers) -> tuple[float, float] | None:
    """Metres from the start to the centre of the cells where the target was seen; None if it was not."""
    cells = np.argwhere(layers["target"] > 0)
    return _metres(*cells.mean(0)) if cells.size else None


def _map(why: Reasons, layers: Layers, pose: tuple[int, int, int], height: int, width: int) -> Image:
    goals = _over_cells(why.goals, pose)
    seen = (layers["explored"] > 0) | (goals > _GLOW * goals.max())
    (i0, i1), (j0, j1) = (_extent(seen.any(axis)) for axis in (1, 0))
    window = (slice(i0, i1), slice(j0, j1))
    cell_px = int(np.clip(min(width / (i1 - i0), height / (j1 - j0)), 1, _MOST_CELL_PX))
    colours = _colours({name: layer[window] for name, layer in layers.items()}, goals[window])
    image = np.repeat(np.repeat(colours.transpose(1, 0, 2)[::-1], cell_px, 0), cell_px, 1).copy()

    def px(x: float, y: float) -> tuple[int, int]:
        return round((x / CELL_M + HALF - i0 + 0.5) * cell_px), round((j1 - y / CELL_M - HALF - 0.5) * cell_px)

    for i, j in np.argwhere(layers["visited"] > 0):
        cv2.circle(image, px(*_metres(i, j)), max(1, cell_px // 4), PATH, -1, cv2.LINE_AA)
    if (at := _target_at(layers)) is not None:
        cv2.drawMarker(image, px(*at), TARGET, cv2.MARKER_TILTED_CROSS, 2 * cell_px, 3)
    middle = px(why.goal_xy[0] + CELL_M / 2, why.goal_xy[1] + CELL_M / 2)  # goals are blocks of 2 x 2 cells
    cv2.circle(image, middle, max(4, cell_px), FLOOR_COLOUR, 4, cv2.LINE_AA)
    cv2.circle(image, middle, max(4, cell_px), GOAL, 2, cv2.LINE_AA)
    direction = HEADING_COS[pose[2] % 4], HEADING_SIN[pose[2] % 4]
    draw_agent(image, px, (pose[0] * CELL_M, pose[1] * CELL_M), direction, cell_px)
    return image


def _extent(seen: NDArray[np.bool_]) -> tuple[int, int]:
    """Range of indices that is drawn (end exclusive): those in ``seen`` with a rim of unknown cells."""
    there = np.flatnonzero(seen)
    return max(int(there[0]) - _RIM, 0), min(int(there[-1]) + 1 + _RIM, SIZE)


def _metres(i: float, j: float) -> tuple[float, float]:
    return (i - HALF) * CELL_M, (j - HALF) * CELL_M


def _over_cells(goals: NDArray[np.float32], pose: tuple[int, int, int]) -> NDArray[np.float32]:
    """Goal probabilities (C, C) around the agent spread over the cells of the whole map, (SIZE, SIZE)."""
    fine = np.repeat(np.repeat(goals, 2, 0), 2, 1)[: 2 * REACH + 1, : 2 * REACH + 1]
    whole = np.zeros((SIZE + 2 * REACH, SIZE + 2 * REACH), np.float32)
    i, j = (int(np.clip(value + HALF, 0, SIZE - 1)) for value in pose[:2])
    whole[i : i + 2 * REACH + 1, j : j + 2 * REACH + 1] = fine
    return whole[REACH : REACH + SIZE, REACH : REACH + SIZE]


def _colours(layer: Layers, goals: NDArray[np.float32]) -> Image:
    """Colours (N, M, 3) of N x M cells: floor, obstacles, opened containers, tinted by goals and belief."""
    colours = np.full((*goals.shape, 3), UNKNOWN, np.uint8)
    colours[layer["explored"] > 0] = FLOOR_COLOUR
    colours[layer["blocked"] > 0] = TALL
    colours[layer["opened"] > 0] = OPENED
    most = float(goals.max(initial=0.0)) or 1.0
    belief = (layer["most"] / 255.0) ** 2  # the memory stores square roots
    for share, colour in ((0.5 * np.sqrt(goals / most), GOAL), (0.85 * belief, WARM)):
        part = share[..., None]
        colours = ((1 - part) * colours + part * np.array(colour)).astype(np.uint8)
    return colours
