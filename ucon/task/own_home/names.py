"""Translates what people call things, rooms and places into the names used here."""

from __future__ import annotations

import re
from functools import cache
from typing import Final, cast

from ucon.core.errors import brief, unknown_name
from ucon.habits.types import Placement
from ucon.language.near_names import unknown_category
from ucon.language.words import stems, synonyms
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS, Relation
from ucon.scenes.room_types import SIZES_M

#: Types of room that can be furnished at random.
ROOM_TYPES: Final = (*SIZES_M, "corridor")
_ROOM_WORDS: Final = {
    "bath": "bathroom", "wc": "bathroom", "toilet": "bathroom", "shower_room": "bathroom",
    "hall": "corridor", "hallway": "corridor", "landing": "corridor", "entrance": "entryway", "foyer": "entryway",
    "lounge": "living_room", "sitting_room": "living_room", "parlour": "living_room", "tv_room": "television_room",
    "study": "private_office", "office": "private_office", "library": "private_office",
    "nursery": "childs_room", "kids_room": "childs_room", "child_s_room": "childs_room",
    "children_s_room": "childs_room",
    "laundry": "utility_room", "laundry_room": "utility_room", "pantry": "pantry_room", "larder": "pantry_room",
    "dressing_room": "closet", "gym": "exercise_room", "store_room": "storage_room", "storage": "storage_room",
    "yard": "garden",
}  # fmt: skip
_JOINED: Final = {name.replace("_", ""): name for name in ROOM_TYPES}
_BEFORE: Final = {
    "ontop": ("on top of", "ontop", "upon", "onto", "on"),
    "inside": ("inside of", "inside", "into", "within", "in"),
    "under": ("underneath", "beneath", "under", "below"),
    "nextto": ("next to", "nextto", "close to", "beside", "near", "by", "at"),
}
_STRUCTURE: Final = {"floor": "floors", "ground": "floors", "wall": "walls", "ceiling": "ceilings"}
_ARTICLE: Final = re.compile(r"(?:the|a|an|my|our|his|her|their) +")


def snake(words: str) -> str:
    """Words as a name: ``living room`` becomes ``living_room``."""
    return re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")


def category_of(words: str) -> str | None:
    """The category that words name: by its name, its plural, or a synonym that no other category has.

    Args:
        words: such as ``top cabinets`` or ``dining table``.
    """
    name = snake(words)
    if name in catalogue():
        return name
    return _by_stems().get(stems(words))


def category_fault(kind: str, words: str) -> str:
    """The message for words that name no category, with the nearest that do.

    Args:
        kind: what they should name, such as ``furniture``.
        words: as they were written.
    """
    return unknown_category(kind, snake(words) or brief(words))


@cache
def _by_stems() -> dict[tuple[str, ...], str]:
    """Categories by the stems of their names and of their synonyms; a name takes precedence over a synonym."""
    found: dict[tuple[str, ...], str | None] = {}
    for category, names in synonyms().items():
        if category in catalogue():
            for name in names:
                found[stems(name)] = category if found.get(stems(name), category) == category else None
    found |= {stems(name): name for name in reversed(catalogue().names)}
    return {words: name for words, name in found.items() if words and name is not None}


def room_type_of(words: str) -> str | None:
    """The type of a room, from its name: ``bedroom 2``, ``Anna's bedroom`` and ``guest_bedroom`` are bedrooms."""
    parts = [part for part in snake(words).split("_") if not part.isdigit()]
    for start in range(len(parts)):
        name = "_".join(parts[start:])
        for one in (name, name.removesuffix("s")):
            if one in _ROOM_WORDS:
                return _ROOM_WORDS[one]
            if (joined := one.replace("_", "")) in _JOINED:  # bed room, livingroom
                return _JOINED[joined]
    return None


def room_type_fault(words: str) -> str:
    """The message for a room of no known type, with the nearest types."""
    return unknown_name("type of room", snake(words) or brief(words), ROOM_TYPES)


def place_of(words: str) -> Placement | str:
    """Parse a placement: ``in the top cabinet``, ``on the floor``, ``next to my laptop``, or ``nextto:laptop``.

    Returns:
        The placement, or what is wrong with the words.
    """
    text = " ".join(words.replace(":", " ").split()).lower()
    for relation, ways in _BEFORE.items():
        for way in ways:
            if text.startswith(f"{way} ") and (thing := _ARTICLE.sub("", text.removeprefix(f"{way} "), count=1)):
                return _anchored(cast(Relation, relation), thing)
    return f"'{brief(words)}', expected one of in, on, under, next to, and a thing, such as: on the breakfast table"


def _anchored(relation: Relation, thing: str) -> Placement | str:
    anchor = _STRUCTURE.get(thing) or category_of(thing)
    if anchor is not None:
        return Placement(relation, anchor)
    first, _, room = thing.rpartition(" in ")
    if first and category_of(first) and room_type_of(_ARTICLE.sub("", room, count=1)):
        return f"'{brief(thing)}': a room cannot be given here; leave ' in {brief(room)}' out"
    return category_fault("thing", thing)


assert set(_BEFORE) == set(RELATIONS)
