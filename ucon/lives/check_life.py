"""Checks of a life's data: those that need no home, and those that need it."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from ucon.core.errors import ConfigError, EpisodeError
from ucon.core.text import is_shown
from ucon.habits.contexts import Context
from ucon.lives.clock import N_SLOTS, SLOT_NAMES, day_and_slot
from ucon.sim.house import House
from ucon.task.check_data import check_object, expect
from ucon.task.rules import task_rules

_TEXTS = ("id", "scene", "home_hash", "habits", "habits_hash", "task", "split", "season")
#: Longest life, days.
MOST_DAYS = 400
MOST_USERS = 3


def check_life(life: Any, where: str) -> None:
    """Refuse a life whose data cannot be right in any home.

    Args:
        life: a :class:`ucon.lives.life.Life` (not in the signature: that module imports this one).
        where: names file and line in the error.

    Raises:
        EpisodeError: names the first wrong field and what was expected.
    """
    for name in _TEXTS:
        expect(_is_text(getattr(life, name)), where, name, getattr(life, name), "a text")
    try:
        task_rules(life.task)
    except ConfigError as error:
        raise EpisodeError(f"{where}: {error}") from None
    for name, least, most in (("days", 1, MOST_DAYS), ("users", 1, MOST_USERS), ("first_weekday", 0, 6)):
        value = getattr(life, name)
        expect(_is_number(value, least, most), where, name, value, f"{least} to {most}")
    expect(isinstance(life.seed, int), where, "seed", life.seed, "a whole number")
    if life.change_day is not None:
        expect(_is_number(life.change_day, 1, life.days - 1), where, "change_day", life.change_day, "a later day")
    expect(life.dock.heading in range(4), where, "dock heading", life.dock.heading, "0 to 3")
    for number, placed in enumerate(life.fixed):
        check_object(placed, f"{where}: fixed object {number}")
    _check_possessions(life, where)
    _check_calendar(life, where)
    _check_times(life, where)


def _check_possessions(life: Any, where: str) -> None:
    count = len(life.possessions)
    expect(count > 0, where, "number of possessions", count, "at least one")
    names = [one.category for one in life.possessions]
    expect(len(set(names)) == count, where, "possessions", sorted(names), "one of a category")
    expect(len(life.at_first) == count, where, "at_first", len(life.at_first), f"{count} of it")
    for one, first in zip(life.possessions, life.at_first, strict=True):
        here = f"{where}: possession {one.category}"
        expect(len(one.entries) > 0 and all(map(_is_text, one.entries)), here, "entries", one.entries, "texts")
        expect(all(map(_is_text, one.later)), here, "later entries", one.later, "texts")
        expect(_is_number(first, 0, len(one.places) - 1), here, "first place", first, f"below {len(one.places)}")
        _check_places(one, here)


def _check_places(one: Any, where: str) -> None:
    for number, place in enumerate(one.places):
        here = f"{where}: place {number}"
        check_object(place.object, here)
        same = place.object.category == one.category
        expect(same, here, "category", place.object.category, one.category)
        right = all(len(o) == 2 and _is_text(o[0]) and type(o[1]) is int for o in place.origins)
        expect(right, here, "origins", place.origins, "an entry and a number each")


def _check_calendar(life: Any, where: str) -> None:
    for day, occasion in life.occasions:
        expect(_is_number(day, 0, life.days - 1), where, "day of an occasion", day, f"below {life.days}")
        try:
            Context(0, 0, life.season, occasion, "household")
        except ConfigError as error:
            raise EpisodeError(f"{where}: {error}") from None
    days = [day for day, _ in life.occasions]
    expect(len(set(days)) == len(days), where, "days of occasions", days, "one occasion a day")


def _check_times(life: Any, where: str) -> None:
    end, count = N_SLOTS * life.days, len(life.possessions)
    expect(len(life.requests) > 0, where, "number of requests", 0, "at least one")
    for name, rows in (("move", life.moves), ("request", life.requests)):
        for one in rows:
            expect(_is_number(one.time, 0, end - 1), where, f"time of a {name}", one.time, f"0 to {end - 1}")
            right = _is_number(one.possession, 0, count - 1)
            expect(right, where, f"possession of a {name}", one.possession, f"below {count}")
        for before, after in pairwise(rows):
            expect(before.time <= after.time, where, f"time of a {name}", _said(after.time), "no earlier one")
    for move in life.moves:
        places = len(life.possessions[move.possession].places)
        expect(_is_number(move.place, 0, places - 1), where, "place of a move", move.place, f"below {places}")
        expect(_is_number(move.user, -1, life.users - 1), where, "user of a move", move.user, f"below {life.users}")
    for asked in life.requests:
        expect(_is_number(asked.user, 0, life.users - 1), where, "who asks", asked.user, f"below {life.users}")
        right = asked.person is None or _is_text(asked.person)
        expect(right, where, "person who asks", asked.person, "a name or null")


def check_life_home(life: Any, house: House) -> None:
    """Refuse a life that does not fit its home.

    Args:
        life: the life.
        house: the compiled home of its ``scene``.

    Raises:
        EpisodeError: the life was made for another version of the home, or names a node or instance that the home
            lacks.
    """
    where = f"life {life.id}"
    if house.spec.hash != life.home_hash:
        raise EpisodeError(
            f"{where}: made for home {life.home_hash[:12]}, {life.scene} is now {house.spec.hash[:12]}; "
            "make the lives again (python -m ucon lives make)"
        )
    places = [place for one in life.possessions for place in one.places]
    cells = [*life.fixed_blocked, *(cell for place in places for cell in place.blocked)]
    nx, ny = house.grid.shape
    for cell in ((life.dock.i, life.dock.j), *cells):
        expect(0 <= cell[0] < nx and 0 <= cell[1] < ny, where, "node", cell, f"below ({nx}, {ny})")
    dock = (life.dock.i, life.dock.j)
    free = bool(house.grid.free[dock]) and dock not in set(cells)
    expect(free, where, "dock", dock, f"a node of {life.scene} that is always free")
    for instance in life.removed:
        right = 0 <= instance < house.n_items
        expect(right, where, "removed instance", instance, f"an item of {life.scene} below {house.n_items}")
    total = house.n_instances + len(life.fixed)
    for number, placed in enumerate((*life.fixed, *(place.object for place in places))):
        for name, value in (("anchor", placed.anchor), ("holder", placed.holder)):
            what = f"{name} of {placed.category} (object {number})"
            expect(-1 <= value < total, where, what, value, f"an instance below {total}, which never moves")


def _said(time: int) -> str:
    day, slot = day_and_slot(time)
    return f"day {day}, {SLOT_NAMES[slot]}"


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and is_shown(value)


def _is_number(value: Any, least: int, most: int) -> bool:
    return type(value) is int and least <= value <= most
