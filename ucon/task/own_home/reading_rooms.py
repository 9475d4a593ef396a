"""Reads the rooms and doors of a home file."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator
from typing import Any, Final

from ucon.core.errors import brief, unknown_name
from ucon.core.untrusted.marked_yaml import Marked
from ucon.habits.book import Faults
from ucon.objects.catalogue import catalogue
from ucon.scenes.procedural import MAX_ROOMS
from ucon.scenes.program import JOINTS
from ucon.task.own_home.names import category_fault, category_of, room_type_fault, room_type_of, snake
from ucon.task.own_home.wish import Door, OwnRoom, Thing

ROOM_KEYS: Final = ("type", "size", "furniture")
#: Shortest and longest side of a room, metres; most of one category in a room, and of all things in a home.
SIDES_M: Final = (1.75, 12.0)
MOST_OF_ONE: Final = 30
MOST_THINGS: Final = 250
_SIZE: Final = re.compile(r"([0-9.]+) *(?:x|by|\*|×) *([0-9.]+) *m?")


class RoomReader:
    """Turns marked values into rooms and doors; collects the faults and leaves out what is wrong."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults

    def _fault(self, where: str, text: str) -> None:
        self._faults.add(where, text)

    def _known_keys(self, node: Marked, known: Collection[str]) -> None:
        for key, where in node.keys.items():
            if key not in known:
                self._fault(where, unknown_name("key", key, known))

    def _word(self, node: Marked, what: str) -> str | None:
        """The value as a name; a list or a mapping is a fault."""
        if isinstance(node.value, list | dict):
            self._fault(node.where, f"{what}: {node.told}, expected a name")
            return None
        return str(node.value)

    # -- rooms ------------------------------------------------------------------------------------------------

    def _rooms(self, node: Marked | None) -> Iterator[OwnRoom]:
        if node is None or node.value is None:
            return
        said = list(self._named_rooms(node))
        if len(said) > MAX_ROOMS:
            self._fault(node.where, f"{len(said)} rooms, expected at most {MAX_ROOMS}; leave some out")
        seen: dict[str, str] = {}
        things = 0
        for called, where, content in said[:MAX_ROOMS]:
            if (key := snake(called)) in seen:
                self._fault(where, f"room '{brief(called)}' is listed twice (first at {seen[key]}); number them")
                continue
            seen[key] = where
            if (room := self._room(called, where, content)) is not None:
                things += sum(thing.count for thing in (room.furniture or {}).values())
                yield room
        if things > MOST_THINGS:
            self._fault(node.where, f"{things:,} things in all rooms, expected at most {MOST_THINGS}")
        if not said and isinstance(node.value, dict | list):
            self._fault(node.where, "no rooms; name some, such as kitchen, or leave 'rooms' out for random ones")
        if len(seen) == 1 and said and room_type_of(said[0][0]) in ("corridor", "garden"):
            self._fault(node.where, f"a home with only a {said[0][0]}; add a room")

    def _named_rooms(self, node: Marked) -> Iterator[tuple[str, str, Marked | None]]:
        """Names of rooms, where in the file they are, and their content."""
        if isinstance(node.value, dict):
            yield from ((name, node.keys[name], content) for name, content in node.value.items())
        elif isinstance(node.value, list):
            for one in node.value:
                if isinstance(one.value, str):
                    yield one.value, one.where, None
                elif isinstance(one.value, dict) and len(one.value) == 1:
                    yield from ((name, one.keys[name], content) for name, content in one.value.items())
                else:
                    self._fault(one.where, f"{one.told}, expected the name of a room, such as kitchen")
        else:
            self._fault(node.where, f"rooms: {node.told}, expected names of rooms, such as kitchen: {{size: [3, 4]}}")

    def _room(self, called: str, where: str, content: Marked | None) -> OwnRoom | None:
        part: dict[str, Marked] = {}
        if content is not None and isinstance(content.value, dict):
            self._known_keys(content, ROOM_KEYS)
            part = content.value
        elif content is not None and content.value is not None:
            part = {"size": content}  # kitchen: [3, 4]
        size = self._size(part.get("size"))
        furniture = self._furniture(part.get("furniture"))
        said = part.get("type")
        words = called if said is None else self._word(said, "type")
        if words is None:
            return None
        room_type = room_type_of(words)
        if room_type is None:
            at = where if said is None else said.where
            hint = "" if said is not None else "; say its type: " + f"{brief(called)}: {{type: bedroom}}"
            self._fault(at, room_type_fault(words) + hint)
            return None
        return OwnRoom(called, room_type, size, furniture, where)

    def _size(self, node: Marked | None) -> tuple[float, float] | None:
        if node is None or node.value is None:
            return None
        found = _SIZE.fullmatch(node.value.strip()) if isinstance(node.value, str) else None
        values = _floats(found.groups()) if found else [one.value for one in node.value] if is_list(node) else []
        low, high = SIDES_M
        if len(values) != 2 or not all(_is_number(v) and low <= v <= high for v in values):
            told = [_short(one) for one in node.value] if is_list(node) else node.told
            self._fault(node.where, f"size: {brief(told)}, expected two sides of {low:g} to {high:g} m: [3, 4.5]")
            return None
        return float(values[0]), float(values[1])

    def _furniture(self, node: Marked | None) -> dict[str, Thing] | None:
        if node is None or node.value is None:
            return None
        found: dict[str, Thing] = {}
        for words, count, where in self._counted(node):
            category = self._buildable(words, where)
            if category is None:
                continue
            if (earlier := found.get(category)) is not None:
                if isinstance(node.value, dict):
                    self._fault(where, f"{category} is listed twice (first at {earlier.where}); keep one line")
                count += earlier.count
            found[category] = Thing(count, where if earlier is None else earlier.where)
        for category, thing in found.items():
            if thing.count > MOST_OF_ONE:
                self._fault(thing.where, f"{thing.count} of {category}, expected at most {MOST_OF_ONE} in a room")
        return found

    def _counted(self, node: Marked) -> Iterator[tuple[str, int, str]]:
        """Words for furniture, how many pieces, and where in the file this is."""
        if isinstance(node.value, dict):
            for words, count in node.value.items():
                if type(count.value) is int and count.value >= 1:
                    yield words, count.value, node.keys[words]
                else:
                    told = f"{brief(words)}: {count.told}, expected how many, a whole number from 1 up"
                    self._fault(node.keys[words], told)
        elif is_list(node):
            for one in node.value:
                if isinstance(one.value, str):
                    yield one.value, 1, one.where
                else:
                    self._fault(one.where, f"furniture: {one.told}, expected a name, such as fridge")
        else:
            self._fault(node.where, f"furniture: {node.told}, expected names, such as {{fridge: 1, top cabinet: 2}}")

    def _buildable(self, words: str, where: str) -> str | None:
        category = category_of(words)
        if category is None:
            self._fault(where, category_fault("furniture", words))
        elif catalogue()[category].mount == "structure" or category == "door":
            self._fault(where, f"{category} is part of the building; leave it out (see 'doors' for doors)")
            return None
        return category

    # -- doors ------------------------------------------------------------------------------------------------

    def _doors(self, node: Marked | None, rooms: list[str]) -> tuple[Door, ...] | None:
        if node is None or node.value is None:
            return None
        if not is_list(node):
            self._fault(node.where, f"doors: {node.told}, expected pairs of rooms, such as [[kitchen, living room]]")
            return None
        doors = [door for one in node.value if (door := self._door(one, rooms)) is not None]
        if len(doors) == len(node.value) and rooms:
            self._joined(doors, rooms, node.where)
        return tuple(doors)

    def _door(self, node: Marked, rooms: list[str]) -> Door | None:
        if not is_list(node) or len(node.value) not in (2, 3):
            self._fault(node.where, "expected two rooms that a door joins, such as [kitchen, living room]")
            return None
        names = [name for one in node.value if (name := self._word(one, "door")) is not None]
        if len(names) < len(node.value):
            return None
        by_key = {snake(room): room for room in rooms}
        for one, name in zip(node.value, names[:2], strict=False):
            if snake(name) not in by_key:
                self._fault(one.where, unknown_name("room", name, rooms))
                return None
        joint = names[2].replace(" ", "_") if len(names) == 3 else None
        if joint is not None and joint not in JOINTS:
            self._fault(node.value[2].where, unknown_name("kind of opening", joint, JOINTS))
            return None
        first, second = (by_key[snake(name)] for name in names[:2])
        return Door(first, second, joint, node.where)

    def _joined(self, doors: list[Door], rooms: list[str], where: str) -> None:
        """Check that the doors form a tree: exactly one way to every room, no circle, no room left out."""
        part = {room: {room} for room in rooms}
        for door in doors:
            if part[door.first] is part[door.second]:
                why = (
                    "joins it to itself" if door.first == door.second else "closes a loop: the rooms are already joined"
                )
                self._fault(door.where, f"the door of {door.first} and {door.second} {why}; leave it out")
                return
            both = part[door.first] | part[door.second]
            part |= dict.fromkeys(both, both)
        if alone := [room for room in rooms if room not in part[rooms[0]]]:
            self._fault(where, f"no door leads from {rooms[0]} to {', '.join(alone)}; add [{rooms[0]}, {alone[0]}]")


def _short(node: Marked) -> Any:
    return node.told if isinstance(node.value, list | dict) else node.value


def is_list(node: Marked) -> bool:
    """Whether a value is a list."""
    return isinstance(node.value, list)


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


def _floats(texts: Collection[str]) -> list[float]:
    try:
        return [float(text) for text in texts]
    except ValueError:
        return []
