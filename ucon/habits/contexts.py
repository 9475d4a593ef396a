"""Contexts: the day, hour, season, occasion or user for which a household keeps a thing in another place.

The book's contexts are free text. ``data/contexts.txt`` maps each of them, reviewed by hand, to conditions:

    summer evenings = season summer; time 18-22
    when guests come = event guests/visit
    for Ines = user Ines

All conditions of a line must hold. A context that the table does not list (in a user's own files) holds only where an
episode states it word for word.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from ucon.core.errors import ConfigError, DataError, brief, unknown_name
from ucon.core.text import is_shown

DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
SEASONS: Final = ("spring", "summer", "autumn", "winter")
EVENT_GROUPS: Final = ("guests", "feast", "travel", "work", "chores", "health", "weather", "family", "hobby")
TABLE: Final = Path(__file__).parent / "data" / "contexts.txt"
#: Probability that an episode that states its context has an occasion.
EVENT_P: Final = 0.5
MAX_LINE: Final = 400
_WAKING_HOURS = range(6, 24)
_SEASON_OF: Final = {
    **dict.fromkeys(("feast/christmas", "feast/advent", "feast/new-year", "feast/hanukkah", "feast/tet"), "winter"),
    **dict.fromkeys(("feast/saint-lucy", "weather/snow", "weather/cold", "hobby/skiing"), "winter"),
    **dict.fromkeys(("feast/easter", "feast/passover", "feast/nowruz", "health/pollen"), "spring"),
    **dict.fromkeys(("feast/halloween", "feast/thanksgiving", "feast/saint-martin", "feast/chuseok"), "autumn"),
    **dict.fromkeys(("feast/rosh-hashanah", "feast/diwali"), "autumn"),
    **dict.fromkeys(("weather/heat", "feast/barbecue", "feast/picnic"), "summer"),
}
"""The season of each occasion that belongs to one, by occasion."""
_DAY_NAMES = ("Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday", "Sunday")
_NAMED_DAYS = {"workday": range(5), "weekend": range(5, 7), "dayoff": range(5, 7)}
_SLUG = re.compile(r"[a-z0-9]+(?:-[a-z0-9]+)*")


@dataclass(frozen=True, slots=True)
class Condition:
    """The condition under which a placement is used; a field of None does not matter.

    Attributes:
        days: 0 (Monday) to 6.
        hours: [from, to) on a 24 h clock; may pass midnight.
        seasons: of :data:`SEASONS`.
        occasion: an event such as ``guests/visit``, or ``other/...`` for texts that name neither day, time, season nor
            event.
        user: who asks, of the people in the household, such as ``Ines``.
    """

    days: frozenset[int] | None = None
    hours: tuple[int, int] | None = None
    seasons: frozenset[str] | None = None
    occasion: str | None = None
    user: str | None = None

    @property
    def kinds(self) -> tuple[str, ...]:
        """Which of day, time, season, user, event, other the condition is about."""
        found = [name for name, value in zip(("day", "time", "season", "user"), self._plain, strict=True) if value]
        if self.occasion:
            found.append("other" if self.occasion.startswith("other/") else "event")
        return tuple(found)

    @property
    def _plain(self) -> tuple[object, ...]:
        return self.days, self.hours, self.seasons, self.user

    def holds(self, context: Context) -> bool:
        """Whether a context fulfils all parts of the condition."""
        if self.days is not None and context.day not in self.days:
            return False
        if self.hours is not None and not between(context.hour, *self.hours):
            return False
        if self.seasons is not None and context.season not in self.seasons:
            return False
        if self.user is not None and self.user != context.user:
            return False
        return self.occasion is None or self.occasion == context.occasion

    def excludes(self, other: Condition) -> bool:
        """Whether no context can fulfil both conditions. An episode has at most one occasion."""
        if self.days is not None and other.days is not None and not self.days & other.days:
            return True
        if self.seasons is not None and other.seasons is not None and not self.seasons & other.seasons:
            return True
        if self.hours is not None and other.hours is not None:
            mine, theirs = self.hours, other.hours
            if not any(between(hour, *mine) and between(hour, *theirs) for hour in range(24)):
                return True
        return any(
            mine is not None and theirs is not None and mine != theirs
            for mine, theirs in ((self.user, other.user), (self.occasion, other.occasion))
        )


@dataclass(frozen=True, slots=True)
class Context:
    """When an episode takes place and who asks.

    Attributes:
        day: 0 (Monday) to 6.
        hour: 0 to 23.
        season: of :data:`SEASONS`.
        occasion: such as ``guests/visit``, or None.
        asker: household of the entry that decides the target's placement.
        user: the person of that household who asks, if its placements depend on that; else None.

    Raises:
        ConfigError: a value outside the calendar, an occasion of no known group, or a text that cannot be shown.
    """

    day: int
    hour: int
    season: str
    occasion: str | None
    asker: str
    user: str | None = None

    def __post_init__(self) -> None:
        """Refuse values that are on no calendar."""
        for name, value, most in (("day", self.day, 6), ("hour", self.hour, 23)):
            if type(value) is not int or not 0 <= value <= most:
                raise ConfigError(f"context: {name} {brief(value)}, expected 0 to {most}")
        if self.season not in SEASONS:
            raise ConfigError(f"context: {unknown_name('season', str(self.season), SEASONS)}")
        for name, text in (("asker", self.asker), ("user", self.user), ("occasion", self.occasion)):
            if not (isinstance(text, str) and text.strip() and is_shown(text)) and (
                text is not None or name == "asker"
            ):
                raise ConfigError(f"context: {name} {brief(repr(text))}, expected a text")
        group, _, what = (self.occasion or "other/none").partition("/")
        if group not in (*EVENT_GROUPS, "other") or not _SLUG.fullmatch(what):
            known = ", ".join(EVENT_GROUPS)
            raise ConfigError(f"context: occasion '{brief(str(self.occasion))}', expected GROUP/NAME of {known}")

    def sentence(self) -> str:
        """The context as a person would say it, for prompts and info."""
        when = f"It is {_DAY_NAMES[self.day]} {part_of_day(self.hour)}, about {self.hour} o'clock, in {self.season}"
        if self.occasion:
            group, _, what = self.occasion.partition("/")
            when += f", on the occasion '{what.replace('-', ' ')}' ({group})"
        who = self.asker if self.user is None else f"{self.user} ({self.asker})"
        return f"{when}, and this is asked by {who}."

    @property
    def occasion_and_user(self) -> str:
        """What is special about it, as words of a retrieval query: ``when there is film night for Ines``."""
        what = "" if self.occasion is None else f"when there is {self.occasion.partition('/')[2].replace('-', ' ')}"
        return f"{what} for {self.user}".strip() if self.user else what

    def to_json(self) -> dict[str, Any]:
        """The context as JSON data."""
        data: dict[str, Any] = {
            "day": DAYS[self.day],
            "hour": self.hour,
            "season": self.season,
            "occasion": self.occasion,
            "asker": self.asker,
        }
        return data if self.user is None else data | {"user": self.user}

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> Context:
        """Read a context from JSON data.

        Raises:
            ValueError: a value is out of its range.
            KeyError: a field is missing.
        """
        day = data["day"]
        if day not in DAYS:
            raise ValueError(f"context: {unknown_name('day', str(day), DAYS)}")
        hour, season, occasion, asker = (data[name] for name in ("hour", "season", "occasion", "asker"))
        try:
            return cls(DAYS.index(day), hour, season, occasion, asker, data.get("user"))
        except ConfigError as error:
            raise ValueError(str(error)) from None


def part_of_day(hour: int) -> str:
    """Morning, afternoon, evening or night.

    Args:
        hour: 0 to 23.
    """
    if between(hour, 22, 6):
        return "night"
    return "morning" if hour < 12 else "afternoon" if hour < 18 else "evening"


def draw_context(rng: np.random.Generator, occasions: Iterable[str], asker: str, users: Iterable[str] = ()) -> Context:
    """Draw a random context; half of them have an occasion.

    Args:
        rng: random numbers.
        occasions: those that matter to the household.
        asker: the household that asks.
        users: the people in it on whom placements depend.
    """
    known = sorted(set(occasions))
    day, hour = int(rng.integers(7)), int(rng.choice(_WAKING_HOURS))
    season = SEASONS[int(rng.integers(len(SEASONS)))]
    pick, happens = rng.random(), rng.random() < EVENT_P
    occasion = known[int(pick * len(known))] if known and happens else None
    people = sorted(set(users))
    user = people[int(rng.integers(len(people)))] if people else None
    return Context(day, hour, season_of(occasion or "") or season, occasion, asker, user)


def season_of(occasion: str) -> str | None:
    """The season to which an occasion belongs; None where it may be in any."""
    return _SEASON_OF.get(occasion)


def condition_of(text: str) -> Condition:
    """The condition of a context of the book.

    Args:
        text: the context; one that the table does not list becomes an occasion ``other/...`` of its own.
    """
    return context_table().get(text) or Condition(occasion=f"other/{_slug(text)}")


@cache
def context_table() -> dict[str, Condition]:
    """Conditions by context of the shipped table, reviewed by hand; read once."""
    return read_contexts(TABLE)


def read_contexts(path: Path) -> dict[str, Condition]:
    """Read a table of contexts.

    Returns:
        Conditions by context.

    Raises:
        DataError: naming file and line of the first fault.
    """
    try:
        lines = path.read_bytes().decode("utf-8").replace("\r\n", "\n").split("\n")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{path}: cannot be read ({error}); expected lines 'context = conditions'") from None
    table: dict[str, Condition] = {}
    for number, line in enumerate(lines, 1):
        where = f"{path}:{number}"
        if len(line) > MAX_LINE or not is_shown(line):
            raise DataError(f"{where}: expected plain text of at most {MAX_LINE} characters; fix the line")
        if not line.strip() or line.startswith("#"):
            continue
        text, equals, conditions = line.partition(" = ")
        if not equals or not text.strip():
            raise DataError(f"{where}: '{line[:60]}', expected 'context = condition; condition'")
        if text in table:
            raise DataError(f"{where}: context '{text}' is listed twice; keep one line")
        table[text] = _condition(where, conditions)
    return table


def _condition(where: str, text: str) -> Condition:
    found: dict[str, Any] = {}
    for part in text.split(";"):
        kind, _, value = part.strip().partition(" ")
        if kind not in _PARSERS:
            raise DataError(
                f"{where}: condition '{part.strip()[:60]}', expected day, time, season, event, user or other"
            )
        field, parse = _PARSERS[kind]
        if field in found:
            raise DataError(f"{where}: two conditions of one kind ('{part.strip()[:60]}'); join them")
        try:
            found[field] = parse(value.strip())
        except ValueError:
            raise DataError(f"{where}: '{part.strip()[:60]}' is no {kind}; see the examples of the table") from None
    return Condition(**found)


def _days(text: str) -> frozenset[int]:
    found: set[int] = set()
    for word in map(str.strip, text.split(",")):
        found |= set(_NAMED_DAYS[word]) if word in _NAMED_DAYS else {DAYS.index(word)}
    return frozenset(found)


def _hours(text: str) -> tuple[int, int]:
    start, end = (int(hour) for hour in text.split("-"))
    if not (0 <= start < 24 and 0 < end <= 24 and start != end):
        raise ValueError(text)
    return start, end


def _seasons(text: str) -> frozenset[str]:
    return frozenset(SEASONS[SEASONS.index(word.strip())] for word in text.split(","))


def _event(text: str) -> str:
    group, _, name = text.partition("/")
    if group not in EVENT_GROUPS or not _SLUG.fullmatch(name):
        raise ValueError(text)
    return text


def _other(text: str) -> str:
    if not _SLUG.fullmatch(text):
        raise ValueError(text)
    return f"other/{text}"


def _user(text: str) -> str:
    if not text:
        raise ValueError(text)
    return text


_PARSERS: Final[dict[str, tuple[str, Any]]] = {
    "day": ("days", _days),
    "time": ("hours", _hours),
    "season": ("seasons", _seasons),
    "event": ("occasion", _event),
    "other": ("occasion", _other),
    "user": ("user", _user),
}


def between(hour: int, start: int, end: int) -> bool:
    """Whether an hour lies in [start, end), which may pass midnight."""
    return start <= hour < end if start < end else hour >= start or hour < end


def _slug(text: str) -> str:
    return "-".join(re.findall(r"[a-z0-9]+", text.lower())) or "unnamed"
