"""The page that shows an agent's reasoning in videos: its map above, lines of text below."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import cv2
import numpy as np

from ucon.perception.drawing.map_picture import Image

INK, FAINT, WARM, GOAL = (40, 40, 44), (120, 120, 126), (226, 92, 30), (36, 120, 200)
"""RGB colours of text, of secondary text, of believed mass, and of the agent's goal."""
_PAPER: Final = (250, 249, 246)
_LINE_PX, _MARGIN_PX, _LETTER_PX = 16, 8, 7
#: Share of the picture's height that the map may take.
_MAP_SHARE: Final = 0.66
_SAID: Final = {"ontop": "on", "inside": "in", "under": "under", "nextto": "by"}
#: Support above which a habit is shown, most habits that are shown, and most lines of each.
_SPEAKS, _MOST_HABITS, _HABIT_LINES = 0.05, 2, 2


class Line(NamedTuple):
    """A line of text and its colour (R, G, B)."""

    text: str
    color: tuple[int, int, int]


def map_room(height: int, width: int) -> tuple[int, int]:
    """The space for the map on a page of this size.

    Returns:
        Height and width in pixels.
    """
    return int(_MAP_SHARE * height), width


def letters(width: int) -> int:
    """Number of letters that fit in one line of a page ``width`` pixels wide."""
    return (width - 2 * _MARGIN_PX) // _LETTER_PX


def page(drawn: Image, lines: Iterable[Line], height: int, width: int) -> Image:
    """Put a map and lines of text on one page.

    Args:
        drawn: picture of the map, (h, w, 3) uint8; scaled down where it is too large.
        lines: text, from top to bottom.
        height: of the page, pixels.
        width: of the page, pixels.

    Returns:
        (height, width, 3) uint8.
    """
    image = np.empty((height, width, 3), np.uint8)
    cv2.rectangle(image, (0, 0), (width, height), _PAPER, -1)  # many times faster than np.full of a colour
    room = map_room(height, width)
    drawn = _fitted(drawn, *room)
    top, left = (room[0] - drawn.shape[0]) // 2, (width - drawn.shape[1]) // 2
    image[top : top + drawn.shape[0], left : left + drawn.shape[1]] = drawn
    y = room[0] + _LINE_PX
    for text, color in lines:
        cv2.putText(image, text, (_MARGIN_PX, y), cv2.FONT_HERSHEY_SIMPLEX, 0.4, color, 1, cv2.LINE_AA)
        y += _LINE_PX
    return image


def _fitted(drawn: Image, height: int, width: int) -> Image:
    """The picture, scaled down where it is larger than ``height`` x ``width``."""
    scale = min(height / drawn.shape[0], width / drawn.shape[1])
    if scale >= 1:
        return drawn
    size = (int(drawn.shape[1] * scale), int(drawn.shape[0] * scale))
    return cv2.resize(drawn, size, interpolation=cv2.INTER_AREA)  # type: ignore[return-value]


def belief_lines(places: Iterable[tuple[str, str, float]], width: int) -> list[Line]:
    """The belief as text of at most two lines.

    Args:
        places: anchor, relation, probability; those of at most 0.005 are left out.
        width: of the page, pixels.
    """
    said = ", ".join(f"{_SAID[relation]} {words(name)} {p:.0%}" for name, relation, p in places if p > 0.005)
    return [Line(line, INK) for line in wrapped(f"believes: {said or 'nothing yet'}", letters(width))[:2]]


def habit_lines(habits: Iterable[tuple[str, float]], width: int) -> list[Line]:
    """The habits that support a place most, each with its support in per cent.

    Args:
        habits: text and support in [0, 1].
        width: of the page, pixels.

    Returns:
        Lines of at most two habits; none where no habit supports the place by more than 0.05.
    """
    strongest = sorted((h for h in habits if h[1] > _SPEAKS), key=lambda h: -h[1])[:_MOST_HABITS]
    lines = []
    for text, weight in strongest:
        lines += [Line(line, FAINT) for line in _short(f'{weight:.0%} "{text}"', letters(width))]
    return lines


def _short(text: str, most: int) -> list[str]:
    """Text in at most ``_HABIT_LINES`` lines, with "..." where something was cut off."""
    lines = wrapped(text, most)
    if len(lines) <= _HABIT_LINES:
        return lines
    return [*lines[: _HABIT_LINES - 1], wrapped(lines[_HABIT_LINES - 1], most - 5)[0] + ' ..."']


def words(name: str) -> str:
    """A category in English: ``coffee_table`` becomes "coffee table"."""
    return name.replace("_", " ")


def wrapped(text: str, most: int) -> list[str]:
    """Break text at its spaces into lines of at most ``most`` letters; a longer word has a line of its own."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > most:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
