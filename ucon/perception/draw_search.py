"""What a searching agent thinks, as a picture: its own map, where it believes the target is, where it goes and why."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.habits.types import RELATIONS
from ucon.perception.draw import Image, Pixels, draw_map, pixels_of
from ucon.perception.places import INSIDE
from ucon.perception.semantic_map import SemanticMap

if TYPE_CHECKING:
    from ucon.envs.waypoint.searcher import Searcher

_PAPER, _INK, _FAINT, _WARM, _GOAL = (250, 249, 246), (40, 40, 44), (120, 120, 126), (226, 92, 30), (36, 120, 200)
_LINE_PX, _MARGIN_PX, _MOST_CELL_PX = 16, 8, 10
#: Share of the picture's height that the map may take.
_MAP_SHARE: Final = 0.66
#: Lines of the habit that speaks for the place.
_HABIT_LINES: Final = 3
#: A habit is shown that speaks so strongly.
_SPEAKS: Final = 0.05
_SAID: Final = {"ontop": "on", "inside": "in", "under": "under", "nextto": "by"}


def draw_search(searcher: Searcher, height: int = 384, width: int = 384) -> Image:
    """Draw the search as it stands: (height, width, 3) uint8.

    Above the agent's own map: the warmer a thing, the greater its part of what is left of the belief; a ring is where
    it goes. Below what it believes most, and the habit that speaks most for the thing it goes to (or believes most).
    """
    image = np.full((height, width, 3), _PAPER, np.uint8)
    known, room = searcher.map, int(_MAP_SHARE * height)
    mass = _mass_left(searcher)
    drawn = _map(searcher, mass, width, room)
    top, left = (room - drawn.shape[0]) // 2, (width - drawn.shape[1]) // 2
    image[top : top + drawn.shape[0], left : left + drawn.shape[1]] = drawn
    y = room + _LINE_PX
    for text, color in _lines(searcher, known, mass, (width - 2 * _MARGIN_PX) // 7):
        cv2.putText(image, text, (_MARGIN_PX, y), cv2.FONT_HERSHEY_SIMPLEX, 0.4, color, 1, cv2.LINE_AA)
        y += _LINE_PX
    return image


def _mass_left(searcher: Searcher) -> NDArray[np.float64]:
    """(T, 4) expected mass of every track and relation that was not looked at in vain."""
    expected, places, n = searcher.expected, searcher.places, searcher.map.n_tracks
    if expected is None or len(expected.mass) != n:
        return np.zeros((n, len(RELATIONS)))
    return places.left(expected.mass)


def _map(searcher: Searcher, mass: NDArray[np.float64], width: int, height: int) -> Image:
    known = searcher.map
    i0, i1, j0, j1 = known.extent()
    cell_px = int(np.clip(min(width / (i1 - i0), height / (j1 - j0)), 1, _MOST_CELL_PX))
    image = draw_map(known, target=searcher.target, cell_px=cell_px)
    px = pixels_of(known, cell_px)
    total = mass.sum(1)
    for track in np.argsort(total, kind="stable").tolist():
        if total[track] > 0.0 and known.seen(track):
            _tint(image, px, known.box[track], float(np.sqrt(total[track] / total.sum())))
    if searcher.choice is not None:
        cv2.circle(image, px(*searcher.choice.view.xy), max(4, cell_px), _GOAL, 2, cv2.LINE_AA)
    if image.shape[0] > height or image.shape[1] > width:
        scale = min(height / image.shape[0], width / image.shape[1])
        image = cv2.resize(
            image, (int(image.shape[1] * scale), int(image.shape[0] * scale)), interpolation=cv2.INTER_AREA
        )  # type: ignore[assignment]
    return image


def _tint(image: Image, px: Pixels, box: NDArray[np.float64], share: float) -> None:
    """Colour the box of a thing."""
    (x0, y0), (x1, y1) = px(box[0], box[4]), px(box[3], box[1])
    part = image[max(y0, 0) : max(y1, y0 + 2), max(x0, 0) : max(x1, x0 + 2)]
    part[:] = ((1 - 0.85 * share) * part + 0.85 * share * np.array(_WARM)).astype(np.uint8)


def _lines(
    searcher: Searcher, known: SemanticMap, mass: NDArray[np.float64], letters: int
) -> list[tuple[str, tuple[int, int, int]]]:
    """What is written below the map."""
    found = searcher.expecting.locations
    if found is None:
        return [(_going(searcher, known, mass), _INK)]
    best = np.argsort(-found.p, axis=None, kind="stable")[:3]
    believed = [(found.names[k // len(RELATIONS)], RELATIONS[k % len(RELATIONS)], found.p.flat[k]) for k in best]
    said = ", ".join(f"{_SAID[relation]} {_words(name)} {p:.0%}" for name, relation, p in believed if p > 0.005)
    lines = [(line, _INK) for line in _wrapped(f"believes: {said or 'nothing yet'}", letters)[:2]]
    lines += [(_going(searcher, known, mass), _GOAL)]
    for thing in (_near_goal(searcher, known, mass), believed[0][0]):
        speaks = found.support(thing) if thing and found.support is not None and found.habits else np.zeros(0)
        if speaks.max(initial=0.0) > _SPEAKS:
            return lines + [
                (line, _FAINT) for line in _wrapped(f'"{found.habits[int(speaks.argmax())]}"', letters)[:_HABIT_LINES]
            ]
    return lines


def _going(searcher: Searcher, known: SemanticMap, mass: NDArray[np.float64]) -> str:
    if searcher.taking:
        return f"goes to: the {_words(searcher.target)}, which it sees"
    if searcher.choice is None:
        return "looks around"
    thing = _near_goal(searcher, known, mass)
    opens = ", to open it" if searcher.choice.opens else ""
    return f"goes to: {_words(thing)}{opens}" if thing else "goes to: what is not explored yet"


def _near_goal(searcher: Searcher, known: SemanticMap, mass: NDArray[np.float64]) -> str:
    """Category of the thing with most mass within two metres of where it goes; "" where there is none to speak of."""
    if searcher.choice is None or not len(mass):
        return ""
    near = np.array([known.seen(t) and known.gap_m(t, searcher.choice.view.xy) < 2.0 for t in range(len(mass))])
    worth = np.where(near, mass[:, INSIDE] if searcher.choice.opens else mass.sum(1), 0.0)
    track = int(worth.argmax())
    return known.category[track] if worth[track] > 0.1 * searcher.choice.gain else ""


def _words(name: str) -> str:
    return name.replace("_", " ")


def _wrapped(text: str, letters: int) -> list[str]:
    """Lines of at most so many letters."""
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > letters:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines
