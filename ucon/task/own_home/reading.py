"""Reads a home file: checks every value and reports all faults at once, each with its line and what would be right."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from ucon.core.errors import UconError, unknown_name
from ucon.core.untrusted.marked_yaml import Marked, marked, read_marked
from ucon.habits.book import Faults, book_anchors
from ucon.habits.rules import OWN_LIMITS, placement_fault
from ucon.habits.types import Placement
from ucon.objects.catalogue import catalogue
from ucon.scenes.library import MAX_SEED, check_home_name, is_home_name
from ucon.scenes.program import HOME_KINDS
from ucon.task.own_home.names import category_fault, category_of
from ucon.task.own_home.places import said_place
from ucon.task.own_home.reading_rooms import RoomReader, is_list
from ucon.task.own_home.sentences import read_habits, shared_out
from ucon.task.own_home.wish import OwnHome, Place, Request

KEYS: Final = ("home", "kind", "seed", "rooms", "doors", "habits", "requests", "things", "others", "starts")
#: Who keeps the other things of a home: the households of the habit book, or nobody.
OTHERS: Final = ("book", "none")
#: Most requests (and most things) of a file, most places of one thing, and most searches for each request.
MOST_REQUESTS: Final = 50
MOST_PLACES: Final = OWN_LIMITS.placements[1]
MOST_STARTS: Final = 100
_LONGEST_NAME: Final = 60


def read_home(source: Path | Mapping[str, Any], instead: Mapping[str, Any] | None = None) -> OwnHome:
    """Read a home file, or the same content as a dict.

    Args:
        source: the file, or the dict.
        instead: values of top-level keys that replace the file's.

    Raises:
        DataError: lists all faults, each with its line.
    """
    found, faults = read_as_far(source, instead)
    raise_in_order(faults, Path(source) if isinstance(source, Path) else Path("home"))
    assert found is not None, "without a fault there is a home"
    return found


def raise_in_order(faults: Faults, file: Path) -> None:
    """Raise an error if there are faults; those in the file are sorted by line, and others come last.

    Args:
        faults: the faults found.
        file: the file read.

    Raises:
        DataError: see :meth:`ucon.habits.book.Faults.raise_if_any`.
    """
    line = re.compile(rf"{re.escape(str(file))}:([0-9]+)")

    def order(fault: str) -> tuple[bool, int]:
        found = line.match(fault)
        return (found is None, 0 if found is None else int(found[1]))

    faults.found.sort(key=order)
    faults.raise_if_any(file)


def read_as_far(source: Path | Mapping[str, Any], instead: Mapping[str, Any] | None = None) -> tuple[OwnHome, Faults]:
    """Read a home file as far as its faults allow, so that the faultless part can be tried too.

    Args:
        source: the file, or the dict.
        instead: values of top-level keys that replace the file's.

    Returns:
        The home with the requests that have no fault, and the faults.

    Raises:
        DataError: the home itself has a fault, so nothing can be tried; lists all faults in order.
    """
    if isinstance(source, Path):
        name, root, folder = str(source), read_marked(source), source.parent
    else:
        name, root, folder = "home", marked(source, "home"), None
    if instead and isinstance(root.value, dict):
        content = {key: marked(value, key) for key, value in instead.items()}
        root = Marked(root.value | content, root.where, {**root.keys, **{key: key for key in content}})
    faults = Faults()
    found = _Reader(faults, name, folder).home(root)
    if found is None:
        raise_in_order(faults, Path(name))
    assert found is not None, "without a fault there is a home"
    return found, faults


class _Asked(NamedTuple):
    """A thing of a known category; ``possible``: its places, if the file names any, have no fault."""

    target: str
    places: tuple[Place, ...]
    where: str
    possible: bool


class _Reader(RoomReader):
    """Turns marked values into a home; collects the faults and leaves out what is wrong."""

    def __init__(self, faults: Faults, name: str, folder: Path | None) -> None:
        super().__init__(faults)
        self._name, self._folder = name, folder

    def home(self, root: Marked) -> OwnHome | None:
        """The home that a document describes; None if it has a fault outside its requests, things and habits."""
        if not isinstance(root.value, dict):
            self._fault(root.where, "expected a home, as `python -m ucon home new FILE.yaml` writes one")
            return None
        self._known_keys(root, KEYS)
        part = root.value
        called = self._called(part.get("home"))
        known = is_home_name(called)
        if known and (extra := [key for key in ("kind", "rooms", "doors", "seed") if key in part]):
            self._fault(root.keys[extra[0]], f"{called} is an existing home: leave this key out or rename yours")
        kind = self._choice(part.get("kind"), "kind of home", HOME_KINDS, "flat")
        seed = self._whole(part.get("seed"), "seed", 0, MAX_SEED, 0)
        starts = self._whole(part.get("starts"), "starts", 1, MOST_STARTS, 1)
        rooms = tuple(self._rooms(part.get("rooms")))
        doors = self._doors(part.get("doors"), [room.called for room in rooms])
        whole = not self._faults.found
        usual = OTHERS["others" in part]  # an unknown word should cause no further faults
        others = self._choice(part.get("others"), "keeper of the other things", OTHERS, usual) == "book"
        asked = [self._asked(part.get(key), key, [room.called for room in rooms]) for key in ("requests", "things")]
        self._check_once(*asked, others=others)
        about = self._about([one for group in asked for one in group], part.get("habits"))
        requests, things = (tuple(about[one] for one in group if one in about) for group in asked)
        if not whole:
            return None
        return OwnHome(
            called, known, kind, seed, rooms, doors, requests, things, others, starts, root.where, self._name
        )

    # -- the home ---------------------------------------------------------------------------------------------

    def _called(self, node: Marked | None) -> str:
        if node is None or node.value is None:
            return Path(self._name).stem
        text = str(node.value) if isinstance(node.value, str | int) and not isinstance(node.value, bool) else ""
        if not text.strip() or len(text) > _LONGEST_NAME:
            self._fault(node.where, f"home: {node.told}, expected a name of at most {_LONGEST_NAME} letters")
        elif is_home_name(text):
            try:
                check_home_name(text)
            except UconError as error:
                self._fault(node.where, str(error))
        return text

    def _choice(self, node: Marked | None, what: str, known: Collection[str], default: str) -> str:
        if node is None:
            return default
        name = self._word(node, what)
        if name is not None and name not in known:
            self._fault(node.where, unknown_name(what, name, known))
            return default
        return default if name is None else name

    def _whole(self, node: Marked | None, what: str, least: int, most: int, default: int) -> int:
        if node is None:
            return default
        if type(node.value) is not int or not least <= node.value <= most:
            self._fault(node.where, f"{what}: {node.told}, expected a whole number from {least} to {most:,}")
            return default
        return node.value

    # -- requests ---------------------------------------------------------------------------------------------

    def _about(self, asked: Sequence[_Asked], habits: Marked | None) -> dict[_Asked, Request]:
        """Things with the sentences about them; things without a sentence or with a faulty place are left out."""
        before = len(self._faults.found)
        sentences = read_habits(habits, self._folder, self._fault)
        sound = len(self._faults.found) == before
        about = shared_out(sentences or [], [one.target for one in asked])
        for one in asked if sentences is not None else ():
            if not about[one.target]:
                name = one.target.replace("_", " ")
                self._fault(one.where, f"no sentence of 'habits' is about the {name}; write one that names it")
        return {
            one: Request(one.target, one.places, tuple(about[one.target]), one.where)
            for one in asked
            if sound and one.possible and about[one.target]
        }

    def _asked(self, node: Marked | None, key: str, rooms: Sequence[str]) -> list[_Asked]:
        """The known things of a list of requests or things."""
        found: list[_Asked] = []
        for words, place, where in () if node is None or node.value is None else self._request_lines(node):
            target = category_of(words)
            if target is None:
                self._fault(where, category_fault("object", words))
            elif catalogue()[target].mount == "structure":
                self._fault(where, f"{target} is part of the building; ask for a thing, such as mug")
            else:
                places = () if place is None else self._places(target, place, rooms)
                found.append(_Asked(target, places, where, place is None or bool(places)))
        if len(found) > MOST_REQUESTS:
            self._fault(found[MOST_REQUESTS].where, f"{len(found)} {key}, expected at most {MOST_REQUESTS}")
        return found[:MOST_REQUESTS]

    def _check_once(self, requests: list[_Asked], things: list[_Asked], *, others: bool) -> None:
        """Check that each thing occurs once, and that only ``others: none`` comes with things or several places."""
        seen: dict[str, str] = {}
        for group in (requests, things):
            for one in list(group):
                if one.target in seen:
                    first = f"first at {seen[one.target]}"
                    self._fault(one.where, f"{one.target} is asked for twice ({first}); a home has only one of it")
                    group.remove(one)
                seen.setdefault(one.target, one.where)
                if others and len(one.places) > 1:
                    name = one.target.replace("_", " ")
                    self._fault(one.where, f"{name}: several places; write `others: none` into the file, or keep one")
        if others and things:
            self._fault(things[0].where, "things: the habit book places them; write `others: none`, or use `requests`")

    def _request_lines(self, node: Marked) -> Iterator[tuple[str, Marked | None, str]]:
        if isinstance(node.value, dict):
            for words, place in node.value.items():
                yield words, None if place.value is None else place, node.keys[words]
        elif is_list(node):
            for one in node.value:
                if isinstance(one.value, dict):
                    yield from self._request_lines(one)
                elif isinstance(one.value, str):
                    yield one.value, None, one.where
                else:
                    self._fault(one.where, f"{one.told}, expected a thing, such as mug: on the breakfast table")
        elif isinstance(node.value, str):
            yield node.value, None, node.where
        else:
            self._fault(node.where, f"requests: {node.told}, expected a list, such as - mug: on the breakfast table")

    def _places(self, target: str, node: Marked, rooms: Sequence[str]) -> tuple[Place, ...]:
        """The places of a thing; empty if one of them has a fault."""
        nodes = list(node.value) if is_list(node) else [node]
        if not 1 <= len(nodes) <= MOST_PLACES:
            self._fault(node.where, f"{target.replace('_', ' ')}: {len(nodes)} places, expected 1 to {MOST_PLACES}")
            return ()
        found: list[Place] = []
        for one in nodes:
            place = self._place(target, one, [place.placement for place in found], rooms)
            if place is None:
                return ()
            found.append(place)
        return tuple(found)

    def _place(self, target: str, node: Marked, earlier: Sequence[Placement], rooms: Sequence[str]) -> Place | None:
        found = (
            said_place(node.value, rooms) if isinstance(node.value, str) else f"{node.told}, expected a place in words"
        )
        if isinstance(found, Place):
            fault = placement_fault(target, earlier, found.placement, book_anchors())
            found = found if fault is None else fault
        if isinstance(found, str):
            self._fault(node.where, f"{target.replace('_', ' ')}: {found}")
            return None
        return found
