"""A memory as a file: JSON that a person can read and correct, checked when it is read.

Places are points in metres in the frame of the dock (x ahead, y to the left, z up), with the relations and anchors of
the thing there, if known. With a detector that errs there are also sizes: the sides of what was seen at each place.
Times are texts such as ``day 3, evening`` (days count from 0).
"""

from __future__ import annotations

import json
import math
from itertools import chain, pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import DataError, brief
from ucon.core.files import write_atomic
from ucon.core.untrusted.strict_json import read_json
from ucon.lives.clock import SLOT_NAMES, day_and_slot, time_of
from ucon.memory.sighting_log import SeenThing, SightingLog
from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS, Spot

#: Version of the stored form.
FORMAT: Final = 2
#: Largest file in bytes, most entries of a list (finding change points takes quadratic time), most days, farthest
#: place in metres.
_MAX_BYTES, _MOST, _MOST_DAYS, _FARTHEST_M = 16 * 2**20, 2_000, 10_000, 100.0
_REMEDY = "fix the file, or begin without it"


def save_log(log: SightingLog, path: Path, home: str) -> None:
    """Write a memory; if interrupted, either the old or the new file remains.

    Args:
        log: the memory.
        path: path of the file.
        home: names the home and the dock that places are relative to.
    """
    things = {
        name: {
            "places": [
                [*(round(float(v), 3) + 0.0 for v in xyz), *chain.from_iterable(spot)]
                for xyz, spot in zip(thing.places, thing.spots, strict=True)
            ],
            "seen": [[_said(time), place] for time, place in thing.seen],
            "absent": [[_said(time), place] for time, place in thing.absent],
            **({"sizes": np.round(thing.size, 3).tolist()} if thing.size.any() else {}),
        }
        for name, thing in sorted(log.things.items())
    }
    lines = [f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in things.items()]
    head = f'{{"format": {FORMAT}, "home": {json.dumps(home)}, "things": {{\n'
    write_atomic(path, head + ",\n".join(lines) + "\n}}\n")


def load_log(path: Path, home: str) -> SightingLog:
    """Read a memory.

    Args:
        path: path of the file.
        home: the home for which it is read.

    Raises:
        DataError: the file is not a memory, is from another version or home, or contradicts itself; names what is
            wrong.
    """
    data = read_json(path, _REMEDY, max_bytes=_MAX_BYTES)
    if not isinstance(data, dict) or data.keys() != {"format", "home", "things"} or type(data["things"]) is not dict:
        raise DataError(f"{path}: expected an object with format, home and things; {_REMEDY}")
    if data["format"] != FORMAT:
        raise DataError(f"{path}: memory format {brief(repr(data['format']))}, expected {FORMAT}; begin without it")
    if data["home"] != home:
        raise DataError(f"{path}: memory of home {brief(repr(data['home']))}, expected {home}; choose that home's file")
    log = SightingLog()
    for name, value in data["things"].items():
        log.things[name] = _thing(name, value, f"{path}: {brief(name)}")
    return log


def log_name(home: str) -> str:
    """File name of a life's memory.

    Args:
        home: id of the life.
    """
    return f"{home.replace('/', '-').replace(':', '-')}.json"


def _thing(name: str, value: Any, where: str) -> SeenThing:
    if name not in catalogue():
        raise DataError(f"{where}: no such category; {_REMEDY}")
    if not isinstance(value, dict) or value.keys() - {"sizes"} != {"places", "seen", "absent"}:
        raise DataError(f"{where}: expected places, seen and absent; {_REMEDY}")
    places = _list(value["places"], f"{where}: places")
    for place in places:
        if not (isinstance(place, list) and len(place) in (3, 5, 7) and all(map(_is_length, place[:3]))):
            found = brief(repr(place))
            raise DataError(f"{where}: place {found}, expected x, y, z in metres, relations and anchors; {_REMEDY}")
        if not all(relation in RELATIONS and _is_category(anchor) for relation, anchor in _spot(place)):
            found = brief(repr(place[3:]))
            raise DataError(f"{where}: {found}, expected one of {', '.join(RELATIONS)} and a category; {_REMEDY}")
    seen = _times(value["seen"], len(places), f"{where}: seen")
    absent = _times(value["absent"], len(places), f"{where}: absent")
    spots = [_spot(place) for place in places]
    xyz, size = np.array([place[:3] for place in places], np.float64).reshape(-1, 3), np.zeros((len(places), 3))
    if "sizes" in value:
        size = _sizes(value["sizes"], len(places), f"{where}: sizes")
    return SeenThing(name, xyz, seen, absent, spots, size)


def _sizes(value: Any, places: int, where: str) -> NDArray[np.float64]:
    rows = _list(value, where)
    good = all(isinstance(row, list) and len(row) == 3 and all(_is_length(v) and v >= 0.0 for v in row) for row in rows)
    if len(rows) != places or not good:
        raise DataError(f"{where}: {brief(repr(value))}, expected three sides in metres of each place; {_REMEDY}")
    return np.array(rows, np.float64).reshape(-1, 3)


def _spot(place: list[Any]) -> Spot:
    return tuple(zip(place[3::2], place[4::2], strict=True))


def _times(value: Any, places: int, where: str) -> list[tuple[int, int]]:
    found = []
    for row in _list(value, where):
        if not (isinstance(row, list) and len(row) == 2 and type(row[1]) is int and 0 <= row[1] < places):
            raise DataError(f"{where}: {brief(repr(row))}, expected a time and a place below {places}; {_REMEDY}")
        found.append((_time(row[0], where), row[1]))
    for before, after in pairwise(found):
        if after[0] < before[0]:
            raise DataError(f"{where}: {_said(after[0])} after {_said(before[0])}; times must not go back; {_REMEDY}")
    return found


def _time(text: Any, where: str) -> int:
    """The time of ``day 3, evening``."""
    day, _, slot = str(text).removeprefix("day ").partition(", ")
    if not (isinstance(text, str) and text.startswith("day ") and day.isdecimal() and day.isascii()):
        raise DataError(f"{where}: time {brief(repr(text))}, expected 'day 3, evening'; {_REMEDY}")
    if slot not in SLOT_NAMES or len(day) > len(str(_MOST_DAYS)):
        raise DataError(f"{where}: time {brief(repr(text))}, expected {', '.join(SLOT_NAMES)} of a day; {_REMEDY}")
    return time_of(int(day), SLOT_NAMES.index(slot))


def _said(time: int) -> str:
    day, slot = day_and_slot(time)
    return f"day {day}, {SLOT_NAMES[slot]}"


def _list(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list) or len(value) > _MOST:
        raise DataError(f"{where}: {brief(repr(value))}, expected a list of at most {_MOST}; {_REMEDY}")
    return value


def _is_category(value: Any) -> bool:
    return isinstance(value, str) and value in catalogue()


def _is_length(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value) and abs(value) <= _FARTHEST_M
