"""Draws a semantic map from above: explored space, furniture, the agent's path, what was opened."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View

#: (H, W, 3) RGB.
Image = NDArray[np.uint8]
#: From x, y in metres in the map's frame to a picture's column and row.
Pixels = Callable[[float, float], tuple[int, int]]

UNKNOWN, FLOOR_COLOUR, LOW, TALL = (58, 62, 70), (238, 236, 230), (206, 188, 160), (134, 116, 98)
PATH, AGENT, OPENED, TARGET = (64, 110, 190), (24, 60, 140), (226, 160, 60), (214, 60, 48)


def pixels_of(known: SemanticMap, cell_px: int) -> Pixels:
    """The function from metres to pixels of a picture that :func:`draw_map` draws.

    Args:
        known: the map that is drawn.
        cell_px: pixels of one 0.25 m cell.

    Returns:
        From x, y in metres in the map's frame to column and row.
    """
    i0, _, _, j1 = known.extent()

    def px(x: float, y: float) -> tuple[int, int]:
        return round((x / CELL_M + HALF - i0 + 0.5) * cell_px), round((j1 - y / CELL_M - HALF - 0.5) * cell_px)

    return px


def draw_map(
    known: SemanticMap, path: Sequence[View] | None = None, *, target: str = "", names: bool = False, cell_px: int = 8
) -> Image:
    """Draw explored space, furniture and path; x to the right, y up, cropped to what was explored.

    Args:
        known: the map.
        path: poses to draw, all of the map's by default.
        target: things of this category are marked with a cross; "" marks none.
        names: write the categories of large things.
        cell_px: pixels of one 0.25 m cell.

    Returns:
        (H, W, 3) uint8.
    """
    i0, i1, j0, j1 = known.extent()
    image = np.full((i1 - i0, j1 - j0, 3), UNKNOWN, np.uint8)
    window = (slice(i0, i1), slice(j0, j1))
    image[known.explored[window] > 0] = FLOOR_COLOUR
    image[known.height[window] > 0.05] = LOW
    image[known.height[window] > 1.2] = TALL
    image = np.repeat(np.repeat(image.transpose(1, 0, 2)[::-1], cell_px, 0), cell_px, 1).copy()
    px = pixels_of(known, cell_px)
    for track in range(known.n_tracks):
        if known.kind[track] or not known.seen(track):
            continue
        x0, y0, _, x1, y1, _ = known.box[track]
        color = OPENED if known.opened[track] else (100, 88, 76)
        cv2.rectangle(image, px(x0, y1), px(x1, y0), color, -1 if known.opened[track] else 1)
        if names and (x1 - x0) * (y1 - y0) > 0.15:
            at = px(x0, (y0 + y1) / 2)
            cv2.putText(
                image, known.category[track][:14], at, cv2.FONT_HERSHEY_PLAIN, 0.7, (30, 30, 30), 1, cv2.LINE_AA
            )
        if known.category[track] == target:
            cv2.drawMarker(image, px((x0 + x1) / 2, (y0 + y1) / 2), TARGET, cv2.MARKER_TILTED_CROSS, 2 * cell_px, 3)
    _draw_path(image, [px(*view.xy) for view in (known.views if path is None else path)], cell_px)
    tip = known.view if path is None or not path else path[-1]
    draw_agent(image, px, tip.xy, tip.direction, cell_px)
    return image


def draw_agent(image: Image, px: Pixels, xy: tuple[float, float], direction: tuple[float, float], cell_px: int) -> None:
    """Draw the agent's position and heading into a picture, in place.

    Args:
        image: (H, W, 3) uint8.
        px: from metres to pixels, of :func:`pixels_of`.
        xy: position in metres in the map's frame.
        direction: cosine and sine of the yaw.
        cell_px: pixels of one 0.25 m cell.
    """
    c, s = direction
    cv2.circle(image, px(*xy), max(3, cell_px * 2 // 3), AGENT, -1, cv2.LINE_AA)
    cv2.line(image, px(*xy), px(xy[0] + 0.5 * c, xy[1] + 0.5 * s), AGENT, 2, cv2.LINE_AA)


def _draw_path(image: Image, points: list[tuple[int, int]], cell_px: int) -> None:
    """Draw the path, darker towards its end."""
    for k, (a, b) in enumerate(itertools.pairwise(points)):
        share = 0.35 + 0.65 * k / len(points)
        color = tuple(round(share * p + (1 - share) * 255) for p in PATH)
        cv2.line(image, a, b, color, max(1, cell_px // 4), cv2.LINE_AA)
