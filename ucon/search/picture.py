"""A search as a picture: the agent's map, its belief about the target's place, its goal and the habits behind it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.objects.model import RELATIONS
from ucon.perception.drawing.map_picture import Image, Pixels, draw_map, pixels_of
from ucon.perception.drawing.overlay import (
    FAINT,
    GOAL,
    INK,
    WARM,
    Line,
    belief_lines,
    habit_lines,
    letters,
    map_room,
    page,
    words,
    wrapped,
)
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.places.place_kernels import INSIDE
from ucon.search.aims import how_sure, suspect_words

if TYPE_CHECKING:
    from ucon.search.searcher import Searcher

#: Most pixels of a 0.25 m cell.
_MOST_CELL_PX = 10
#: Suspects less probable than this are not marked.
_LEAST_SHOWN = 0.02


def draw_search(searcher: Searcher, height: int = 384, width: int = 384, *, also: str = "") -> Image:
    """Draw the current state of a search.

    Above is the agent's own map: the redder a thing, the larger its part of the remaining mass; a ring marks the goal.
    Below are the most probable places, and the habits that support the goal (or the most probable place) most, with
    their support from 0 to 100 %.

    Args:
        searcher: the search.
        height: of the picture, pixels.
        width: of the picture, pixels.
        also: a last line of text, for agents with more to show.

    Returns:
        (height, width, 3) uint8.
    """
    mass = _mass_left(searcher)
    lines = _lines(searcher, searcher.map, mass, width) + ([Line(also, FAINT)] if also else [])
    return page(_map(searcher, mass, *map_room(height, width)), lines, height, width)


def _mass_left(searcher: Searcher) -> NDArray[np.float64]:
    """(T, 4) expected mass of tracks and relations that remains after the looks so far."""
    expected, places, n = searcher.expected, searcher.places, searcher.map.n_tracks
    if expected is None or len(expected.mass) != n:
        return np.zeros((n, len(RELATIONS)))
    return places.remaining_mass(expected.mass)


def _map(searcher: Searcher, mass: NDArray[np.float64], height: int, width: int) -> Image:
    """The map with the remaining mass (T, 4) and the goal."""
    known = searcher.map
    i0, i1, j0, j1 = known.extent()
    cell_px = int(np.clip(min(width / (i1 - i0), height / (j1 - j0)), 1, _MOST_CELL_PX))
    image = draw_map(known, target=searcher.target, cell_px=cell_px)
    px = pixels_of(known, cell_px)
    total = mass.sum(1)
    for track in np.argsort(total, kind="stable").tolist():
        if total[track] > 0.0 and known.seen(track):
            _tint(image, px, known.box[track], float(np.sqrt(total[track] / total.sum())))
    for track, p in ({} if searcher.doubt is None else searcher.doubt.p).items():
        if p >= _LEAST_SHOWN:
            _mark(image, px, known.box[track], p)
    if searcher.choice is not None:
        cv2.circle(image, px(*searcher.choice.view.xy), max(4, cell_px), GOAL, 2, cv2.LINE_AA)
    return image


def _mark(image: Image, px: Pixels, box: NDArray[np.float64], p: float) -> None:
    """Ring a suspect, and write how probable it is that it is the target."""
    at = px(0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]))
    cv2.circle(image, at, 5, WARM, 1 + int(2 * p), cv2.LINE_AA)
    cv2.putText(image, f"{p:.0%}", (at[0] + 7, at[1] + 4), cv2.FONT_HERSHEY_PLAIN, 0.8, (30, 30, 30), 1, cv2.LINE_AA)


def _tint(image: Image, px: Pixels, box: NDArray[np.float64], share: float) -> None:
    """Colour the box of a thing; ``share`` from 0 to 1 is the strength."""
    (x0, y0), (x1, y1) = px(box[0], box[4]), px(box[3], box[1])
    part = image[max(y0, 0) : max(y1, y0 + 2), max(x0, 0) : max(x1, x0 + 2)]
    part[:] = ((1 - 0.85 * share) * part + 0.85 * share * np.array(WARM)).astype(np.uint8)


def _lines(searcher: Searcher, known: SemanticMap, mass: NDArray[np.float64], width: int) -> list[Line]:
    """The text below the map."""
    found, going = searcher.expecting.locations, wrapped(_going(searcher, known, mass), letters(width))[:2]
    if found is None:
        return [Line(line, INK) for line in going]
    best = np.argsort(-found.p, axis=None, kind="stable")[:3]
    places = [(found.names[k // len(RELATIONS)], RELATIONS[k % len(RELATIONS)], float(found.p.flat[k])) for k in best]
    lines = [*belief_lines(places, width), *(Line(line, GOAL) for line in going)]
    for thing in (_near_goal(searcher, known, mass), places[0][0]):
        support = found.support(thing) if thing and found.support is not None else ()
        if speaks := habit_lines(zip(found.habits, map(float, support), strict=False), width):
            return lines + speaks
    return lines


def _going(searcher: Searcher, known: SemanticMap, mass: NDArray[np.float64]) -> str:
    """The goal as text."""
    if searcher.taking and searcher.doubt is not None:
        return f"is it the {words(searcher.target)}? {suspect_words(searcher)}: {how_sure(searcher)}"
    if searcher.taking:
        return f"goes to: the {words(searcher.target)}, which it sees"
    if searcher.choice is None:
        return "looks around"
    thing = _near_goal(searcher, known, mass)
    opens = ", to open it" if searcher.choice.opens else ""
    return f"goes to: {words(thing)}{opens}" if thing else "goes to: unexplored space"


def _near_goal(searcher: Searcher, known: SemanticMap, mass: NDArray[np.float64]) -> str:
    """Category of the thing with most mass within 2 m of the goal; "" where its mass is below a tenth of the gain."""
    if searcher.choice is None or not len(mass):
        return ""
    near = np.array([known.seen(t) and known.gap_m(t, searcher.choice.view.xy) < 2.0 for t in range(len(mass))])
    worth = np.where(near, mass[:, INSIDE] if searcher.choice.opens else mass.sum(1), 0.0)
    track = int(worth.argmax())
    return known.category[track] if worth[track] > 0.1 * searcher.choice.gain else ""
