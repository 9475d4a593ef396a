"""Places in everyday English: on the shelf in the study, at the foot of the bed, behind the laptop."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Final

from ucon.core.errors import brief
from ucon.sim.placement.spot import Side
from ucon.task.own_home.names import place_of, snake
from ucon.task.own_home.wish import Place
from ucon.task.spoken import spoken_place

_FACING: Final = re.compile(r",? facing its front$")
#: Words before the anchor, the plain relation they stand for, and the side of the anchor.
_SIDES: Final[tuple[tuple[str, str, Side], ...]] = (
    (r"(?:at|on) the foot(?: end)? of", "on", "front"),
    (r"(?:at|on) the head(?: end)? of", "on", "behind"),
    (r"behind", "next to", "behind"),
    (r"in front of", "next to", "front"),
    (r"(?:to the )?left of", "next to", "left"),
    (r"(?:to the )?right of", "next to", "right"),
    (r"on the front of", "on", "front"),
    (r"on the back of", "on", "behind"),
    (r"on the left(?: side)? of", "on", "left"),
    (r"on the right(?: side)? of", "on", "right"),
)


def said_place(words: str, rooms: Collection[str]) -> Place | str:
    """Parse a place given in English.

    Args:
        words: such as ``on the shelf in the study``, ``at the foot of the bed``, ``on the desk, facing its front``.
        rooms: names of the home's rooms.

    Returns:
        The place, or what is wrong with the words.
    """
    text = " ".join(words.split())
    facing = _FACING.search(text) is not None
    text, room = _without_room(_FACING.sub("", text), rooms)
    text, side = _without_side(text)
    placement = place_of(text)
    if isinstance(placement, str):
        return placement
    if facing and placement.relation != "ontop":
        return f"'{brief(words)}': only a thing on top of another can face its front; expected such as: on the desk"
    return Place(placement, side, facing, room)


def _without_room(text: str, rooms: Collection[str]) -> tuple[str, str | None]:
    """The words before ``in the ROOM``, and the room or None."""
    before, _, last = text.rpartition(" in ")
    by_name = {snake(room): room for room in rooms}
    for name in (last, last.removeprefix("the ")):
        if before and snake(name) in by_name:
            return before, by_name[snake(name)]
    return text, None


def _without_side(text: str) -> tuple[str, Side | None]:
    """The words with a plain relation in place of one that names a side, and the side or None."""
    for words, plain, side in _SIDES:
        if found := re.match(rf"{words} ", text, re.IGNORECASE):
            return f"{plain} {text[found.end() :]}", side
    return text, None


def spoken(place: Place) -> str:
    """A place in words, as in ``behind the laptop in the study``."""
    plain = spoken_place(place.placement.relation, place.placement.anchor)
    anchor = place.placement.anchor.replace("_", " ")
    if place.side is not None:
        plain = f"{_beside(place)} the {anchor}"
    return plain + (f" in the {place.room}" if place.room else "") + (", facing its front" if place.facing else "")


def _beside(place: Place) -> str:
    if place.placement.relation == "nextto":
        return {"front": "in front of", "behind": "behind", "left": "left of", "right": "right of"}[place.side or ""]
    if place.placement.anchor == "bed" and place.side in ("front", "behind"):
        return f"at the {'foot' if place.side == 'front' else 'head'} of"
    return f"on the {'back' if place.side == 'behind' else place.side} of"
