"""Habits that a robot found out itself, as sentences: where a thing was seen, how often, and when last.

A sentence is written for a place where a thing was seen on at least two days since its habits last changed, and in a
certain share of all sightings, if the thing came there more than once or was never seen elsewhere: a thing seen at a
place only for a while may have been left there by mistake. A sentence about a part of the week or of the day is written
if the place is usual at these times and less so at others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from ucon.core.sharing import Shared
from ucon.language.phrases import phrase
from ucon.lives.clock import N_SLOTS, SLOT_NAMES, is_weekend, weekday_of
from ucon.memory.sighting_log import SeenThing
from ucon.objects.model import Spot
from ucon.task.spoken import spoken_place

#: Least number of sightings and of days, and least share of all sightings, for a sentence about a place.
LEAST_TIMES, LEAST_DAYS, LEAST_SHARE = 2, 2, 0.25
#: Least number and share of sightings within a part of the week or day, and by how much the share exceeds the overall.
THEN_TIMES, THEN_SHARE, THEN_MORE = 3, 0.7, 0.25


@dataclass(frozen=True)
class AcquiredHabit(Shared):
    """One habit of one thing.

    Attributes:
        thing: category of the thing.
        spot: relations and anchor categories.
        when: part of the week or of the day, such as ``in the morning``; "" for any time.
        times: how often the thing was seen there at such times.
        of: how often it was seen anywhere at such times.
        last_day: day on which it was last seen there at such a time, from 0.
    """

    thing: str
    spot: Spot
    when: str
    times: int
    of: int
    last_day: int

    @property
    def text(self) -> str:
        """The habit as a sentence; here days count from 1, as people count them."""
        begins = f"{self.when[0].upper()}{self.when[1:]} the" if self.when else "The"
        often = f"{self.times} of {self.of} times"
        return f"{begins} {phrase(self.thing)} has been {spoken(self.spot)}, {often}, last on day {self.last_day + 1}."


def acquired_habits(thing: SeenThing, first: int, first_weekday: int) -> list[AcquiredHabit]:
    """What the sightings of a thing say about its habits, those seen most often first.

    Args:
        thing: what is known about the thing.
        first: number of the first sighting that counts; before it, the habits were different.
        first_weekday: weekday of day 0: 0 (Monday) to 6.
    """
    seen = _times(thing, first)
    found = []
    for when, holds in _parts(first_weekday):
        then = [(time, spot) for time, spot in seen if holds(time)]
        for spot in dict.fromkeys(spot for _, spot in then):
            at = [time for time, here in then if here == spot]
            days, always = len({time // N_SLOTS for time in at}), sum(here == spot for _, here in seen)
            is_usual = (
                _is_usual(len(at), len(then)) if not when else _is_usual_then(len(at), len(then), always / len(seen))
            )
            if days >= LEAST_DAYS and is_usual and _is_kept(spot, seen):
                found.append(AcquiredHabit(thing.name, spot, when, len(at), len(then), at[-1] // N_SLOTS))
    return sorted(found, key=lambda habit: (-habit.times, habit.when, habit.spot))


def _is_kept(spot: Spot, seen: Sequence[tuple[int, Spot]]) -> bool:
    """Whether a thing was put at a spot more than once, as far as was seen, or never anywhere else."""
    spots = [here for _, here in seen]
    arrivals = sum(here == spot and before != spot for before, here in pairwise(((), *spots)))
    return arrivals > 1 or set(spots) == {spot}


def _is_usual(times: int, of: int) -> bool:
    return times >= LEAST_TIMES and times >= LEAST_SHARE * of


def _is_usual_then(times: int, of: int, always: float) -> bool:
    """Whether a spot is usual in a part of the week or of the day, and more so than overall (share ``always``)."""
    return times >= THEN_TIMES and times >= THEN_SHARE * of and times / of >= always + THEN_MORE


def _times(thing: SeenThing, first: int) -> list[tuple[int, Spot]]:
    """Time and spot of the sightings that count; one per slot, since nobody moves things within a slot."""
    by_time = {time: thing.spots[place] for time, place in thing.seen[first:]}
    return [(time, spot) for time, spot in by_time.items() if spot]


def _parts(first_weekday: int) -> Iterator[tuple[str, Callable[[int], bool]]]:
    """Parts of the week and of the day: words, and whether a time is in it."""
    yield "", _ever
    yield "on workdays", partial(_in_week, False, first_weekday)
    yield "at the weekend", partial(_in_week, True, first_weekday)
    for slot, name in enumerate(SLOT_NAMES):
        yield f"at {name}" if name == "midday" else f"in the {name}", partial(_in_day, slot)


def _ever(time: int) -> bool:
    return True


def _in_week(weekend: bool, first_weekday: int, time: int) -> bool:
    return is_weekend(weekday_of(time // N_SLOTS, first_weekday)) == weekend


def _in_day(slot: int, time: int) -> bool:
    return time % N_SLOTS == slot


def spoken(spot: Spot) -> str:
    """A spot in words, such as ``on the countertop, beside the sink``."""
    return ", ".join(spoken_place(relation, anchor) for relation, anchor in spot)


def texts_of(habits: Sequence[AcquiredHabit]) -> tuple[str, ...]:
    """The sentences."""
    return tuple(habit.text for habit in habits)
