"""Words of the calendar: which days, hours and seasons a sentence names.

Hours are those that ``ucon/habits/data/contexts.txt`` gives to the same words ("mornings = time 6-10").
"""

from __future__ import annotations

import re
from typing import Final

from ucon.habits.contexts import SEASONS, between
from ucon.language.words import tokens

_DAY_NAMES: Final = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
_DAYS: Final = {name: frozenset({k}) for k, name in enumerate(_DAY_NAMES)} | {
    **dict.fromkeys(("weekday", "workday"), frozenset(range(5))),
    "weekend": frozenset({5, 6}),
}
_RANGE: Final = re.compile(rf"\b({'|'.join(_DAY_NAMES)})s? (?:to|till|until|through|and) ({'|'.join(_DAY_NAMES)})")
_WORKING: Final = re.compile(
    r"\bfrom monday on|\b(?:work|working|school|office) (?:day|morning|week)|\b(?:during|in) the (?:working )?week\b"
)
_HOURS: Final = {
    **dict.fromkeys(("morning", "breakfast"), (6, 10)),
    **dict.fromkeys(("dawn", "sunrise"), (5, 8)),
    **dict.fromkeys(("noon", "midday", "lunch"), (11, 14)),
    "afternoon": (12, 18),
    **dict.fromkeys(("evening", "supper", "dinner", "dusk"), (18, 22)),
    **dict.fromkeys(("night", "midnight"), (22, 6)),
    "bedtime": (21, 24),
    "tonight": (18, 24),
}
_MONTHS: Final = {
    **dict.fromkeys(("March", "April"), "spring"),
    **dict.fromkeys(("June", "July", "August"), "summer"),
    **dict.fromkeys(("September", "October", "November"), "autumn"),
    **dict.fromkeys(("December", "January", "February"), "winter"),
}
"""May is left out: at the start of a sentence it is mostly the verb."""
_NAME: Final = re.compile(r"[A-Z]\w+")
_TITLES: Final = frozenset({"Mr", "Mrs", "Miss", "Ms", "Dr"})


def days_named(text: str) -> frozenset[int]:
    """Days, 0 (Monday) to 6, that a sentence names; a range such as "Monday to Friday" names all days between."""
    low = text.lower()
    found = set().union(*(_DAYS.get(word.removesuffix("s"), ()) for word in tokens(low)))
    for first, last in _RANGE.findall(low):
        start, end = _DAY_NAMES.index(first), _DAY_NAMES.index(last)
        found |= {day % 7 for day in range(start, end + 1 if start <= end else end + 8)}
    return frozenset(found | (set(range(5)) if _WORKING.search(low) else set()))


def hours_named(text: str) -> frozenset[int]:
    """Hours, 0 to 23, that a sentence names."""
    spans = [_HOURS[name] for word in tokens(text) if (name := word.removesuffix("s")) in _HOURS]
    return frozenset(hour for hour in range(24) if any(between(hour, *span) for span in spans))


def seasons_named(text: str) -> frozenset[int]:
    """Numbers of the seasons (:data:`ucon.habits.contexts.SEASONS`) that a sentence names, by name or by month."""
    named = {word.removesuffix("s") for word in tokens(text)} & set(SEASONS)
    named |= {_MONTHS[name] for name in _NAME.findall(text) if name in _MONTHS}
    return frozenset(map(SEASONS.index, named))


def names_in(text: str) -> frozenset[str]:
    """Capitalised words of a text except titles; names of people are among them."""
    return frozenset(_NAME.findall(text)) - _TITLES
