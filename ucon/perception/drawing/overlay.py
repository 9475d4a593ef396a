"""The page on which an agent's thoughts are drawn, for videos: its map above, some lines of text below."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import cv2
import numpy as np

from ucon.perception.drawing.map_picture import Image

INK, FAINT, WARM, GOAL = (40, 40, 44), (120, 120, 126), (226, 92, 30), (36, 120, 200)
"""Of text, of lesser text, of where the target is believed to be, and of where the agent goes."""
_PAPER: Final = (250, 249, 246)
_LINE_PX, _MARGIN_PX, _LETTER_PX = 16, 8, 7
#: Share of the picture's height that the map may take.
_MAP_SHARE: Final = 0.66
_SAID: Final = {"ontop": "on", "inside": "in", "under": "under", "nextto": "by"}
#: A habit is shown that speaks so strongly; so many of them, in so many lines each.
_SPEAKS, _MOST_HABITS, _HABIT_LINES = 0.05, 2, 2


class Line(NamedTuple):
    """A line of text."""

    text: str
    color: tuple[int, int, int]


def map_room(height: int, width: int) -> tuple[int, int]:
    """Height and width in pixels that a page of this size has for its map."""
    return int(_MAP_SHARE * height), width


def letters(width: int) -> int:
    """How many letters a line of a page of this width holds."""
    return (width - 2 * _MARGIN_PX) // _LETTER_PX


def page(drawn: Image, lines: Iterable[Line], height: int, width: int) -> Image:
    """A map and lines as one picture, (height, width, 3) uint8; a map that is too large is made smaller."""
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
    scale = min(height / drawn.shape[0], width / drawn.shape[1])
    if scale >= 1:
        return drawn
    size = (int(drawn.shape[1] * scale), int(drawn.shape[0] * scale))
    return cv2.resize(drawn, size, interpolation=cv2.INTER_AREA)  # type: ignore[return-value]


def believes(places: Iterable[tuple[str, str, float]], width: int) -> list[Line]:
    """At most two lines of what is believed: anchor, relation, probability."""
    said = ", ".join(f"{_SAID[relation]} {words(name)} {p:.0%}" for name, relation, p in places if p > 0.005)
    return [Line(line, INK) for line in wrapped(f"believes: {said or 'nothing yet'}", letters(width))[:2]]


def speaking(habits: Iterable[tuple[str, float]], width: int) -> list[Line]:
    """The habits that speak most for a place, each with how strongly it does."""
    strongest = sorted((h for h in habits if h[1] > _SPEAKS), key=lambda h: -h[1])[:_MOST_HABITS]
    lines = []
    for text, weight in strongest:
        lines += [Line(line, FAINT) for line in _short(f'{weight:.0%} "{text}"', letters(width))]
    return lines


def _short(text: str, most: int) -> list[str]:
    lines = wrapped(text, most)
    if len(lines) <= _HABIT_LINES:
        return lines
    return [*lines[: _HABIT_LINES - 1], wrapped(lines[_HABIT_LINES - 1], most - 5)[0] + ' ..."']


def words(name: str) -> str:
    """A category as it is spoken."""
    return name.replace("_", " ")


def wrapped(text: str, most: int) -> list[str]:
    """Lines of at most so many letters."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > most:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
