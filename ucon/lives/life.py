"""A life: days in one home as plain data, made once, checked once, stored and replayed.

Every possession has a few places in the home, fixed when the life was made. At any time it is at one of them, and any
choice of one place for each possession fits together. So the home at any time is known without any simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any

from ucon.core.errors import EpisodeError, brief
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.sharing import Shared
from ucon.habits.contexts import Context
from ucon.lives.check_life import check_life
from ucon.lives.clock import HOURS, weekday_of
from ucon.sim.arrangement import PlacedObject
from ucon.task.episode import Start

#: Version of the stored form.
FORMAT = 1


@dataclass(frozen=True, slots=True)
class Place:
    """One place of a possession.

    Attributes:
        object: the possession at this place; its ``anchor`` and ``holder`` are instances of the home or fixed objects.
        blocked: nodes of the grid that it blocks there.
        origins: placements that name this place, as (entry id, placement index); () for a place used by mistake only.
    """

    object: PlacedObject
    blocked: tuple[tuple[int, int], ...]
    origins: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class Possession:
    """A thing of the household, the only one of its category in the home.

    Attributes:
        category: category of the thing.
        entries: ids of the entries by which it is kept at first; user u follows number ``u % len(entries)``.
        later: ids of its entries from the day of the change on; () if nothing changes.
        places: where it may be.
    """

    category: str
    entries: tuple[str, ...]
    later: tuple[str, ...]
    places: tuple[Place, ...]


@dataclass(frozen=True, slots=True)
class Move:
    """A possession is put somewhere, before the requests of the slot.

    Attributes:
        time: see :func:`ucon.lives.clock.time_of`.
        possession: number of the possession.
        place: number of the place.
        user: who put it there; -1 for a mistake.
    """

    time: int
    possession: int
    place: int
    user: int


@dataclass(frozen=True, slots=True)
class Request:
    """The robot is asked for a possession.

    Attributes:
        time: see :func:`ucon.lives.clock.time_of`.
        possession: number of the possession.
        user: who asks.
        person: name of the person, if placements of the user's entry depend on a person.
    """

    time: int
    possession: int
    user: int
    person: str | None


@dataclass(frozen=True)
class Life(Shared):
    """Days in one home. Everything except the clock and the habits given is privileged."""

    id: str
    scene: str
    """Name of the home."""
    home_hash: str
    """Hash of the home's specification."""
    habits: str
    """Name of the habit dataset."""
    habits_hash: str
    """SHA-256 of the habit dataset."""
    task: str
    """Rule set under which every request can be met."""
    seed: int
    split: str
    """Label of the group within its set."""
    days: int
    users: int
    """Number of people, 1 to 3."""
    first_weekday: int
    """Weekday of day 0: 0 (Monday) to 6."""
    season: str
    occasions: tuple[tuple[int, str], ...]
    """(day, occasion) for each day that has an occasion."""
    change_day: int | None
    """Day on whose morning possessions with ``later`` entries change to these; None: nothing changes."""
    removed: tuple[int, ...]
    """Instances that are removed from the home: its own items of the possessions' categories."""
    fixed: tuple[PlacedObject, ...]
    """Anchors that were added to the home; they never move."""
    fixed_blocked: tuple[tuple[int, int], ...]
    """Nodes of the grid that the fixed objects block."""
    dock: Start
    """Where the robot stands every morning."""
    possessions: tuple[Possession, ...]
    at_first: tuple[int, ...]
    """Place of each possession before the first morning."""
    moves: tuple[Move, ...]
    """Moves in order of time."""
    requests: tuple[Request, ...]
    """Requests in order of time."""

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the canonical JSON, in hexadecimal."""
        return sha256_bytes(canonical_json(self.to_json()).encode())

    def weekday(self, day: int) -> int:
        """Weekday of a day, 0 (Monday) to 6."""
        return weekday_of(day, self.first_weekday)

    def occasion(self, day: int) -> str | None:
        """The occasion of a day, such as ``guests/visit``."""
        return dict(self.occasions).get(day)

    def entries_at(self, possession: int, day: int) -> tuple[str, ...]:
        """Ids of the entries by which a possession is kept on a day."""
        one = self.possessions[possession]
        changed = self.change_day is not None and day >= self.change_day and one.later
        return one.later if changed else one.entries

    def entry_of(self, possession: int, day: int, user: int) -> str:
        """Id of the entry by which a user keeps a possession on a day."""
        entries = self.entries_at(possession, day)
        return entries[user % len(entries)]

    def context(self, day: int, slot: int, asker: str, person: str | None) -> Context:
        """Day, hour, season and occasion of a slot, and who asks.

        Args:
            day: from 0.
            slot: 0 to 2.
            asker: household of the entry.
            person: person of that household; None if its placements depend on nobody.
        """
        return Context(self.weekday(day), HOURS[slot], self.season, self.occasion(day), asker, person)

    def to_json(self) -> dict[str, Any]:
        """The life as JSON data; places, moves and requests are lists in the order of their fields."""
        data = asdict(self) | {"format": FORMAT}
        data["fixed"] = [_row(placed) for placed in self.fixed]
        data["dock"] = _row(self.dock)
        data["possessions"] = [
            [p.category, list(p.entries), list(p.later), [[_row(s.object), *_row(s)[1:]] for s in p.places]]
            for p in self.possessions
        ]
        data["moves"] = [_row(move) for move in self.moves]
        data["requests"] = [_row(request) for request in self.requests]
        return data

    @classmethod
    def from_json(cls, data: dict[str, Any], *, where: str = "life") -> Life:
        """Read a life from JSON data.

        Args:
            data: what :meth:`to_json` returns.
            where: names file and line in errors.

        Raises:
            EpisodeError: a field is missing or wrong, or the format is another one.
        """
        try:
            if data.get("format") != FORMAT:
                found = brief(repr(data.get("format")))
                raise EpisodeError(f"{where}: life format {found}, expected {FORMAT}; make it again")
            raw = {name: _frozen(value) for name, value in data.items() if name != "format"}
            raw["fixed"] = _rows(PlacedObject, raw["fixed"])
            raw["dock"] = Start(*raw["dock"])
            raw["possessions"] = tuple(_possession(row) for row in raw["possessions"])
            raw["moves"], raw["requests"] = _rows(Move, raw["moves"]), _rows(Request, raw["requests"])
            life = cls(**raw)
            check_life(life, where)
        except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
            raise EpisodeError(
                f"{where}: not a usable life ({brief(str(error))}); restore or make the file again"
            ) from None
        return life


def _possession(row: Sequence[Any]) -> Possession:
    category, entries, later, places = row
    read = tuple(Place(_rows(PlacedObject, [placed])[0], blocked, origins) for placed, blocked, origins in places)
    return Possession(category, entries, later, read)


def _rows(kind: Any, rows: Sequence[Sequence[Any]]) -> tuple[Any, ...]:
    """Objects of a dataclass, from lists in the order of its fields."""
    names = [field.name for field in fields(kind)]
    return tuple(kind(**dict(zip(names, row, strict=True))) for row in rows)


def _row(value: Any) -> list[Any]:
    """A dataclass as a list in the order of its fields; floats are rounded to 6 decimals."""
    return [_plain(getattr(value, field.name)) for field in fields(value)]


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, 6) + 0.0
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def _frozen(value: Any) -> Any:
    """The value with its lists turned into tuples."""
    return tuple(_frozen(v) for v in value) if isinstance(value, list) else value
