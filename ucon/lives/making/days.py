"""Days of a life: who uses which things, where they are put, and what people ask for.

At every slot each possession is used with probability :data:`USED` by one of the people. It is then put where a
placement of the user's entry with a fulfilled context says, or else where one without a context says; with probability
:data:`MISTAKEN` it is left somewhere else instead. What is not used stays where it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import EpisodeError
from ucon.core.rng import stream
from ucon.habits.contexts import SEASONS, condition_of, season_of
from ucon.habits.types import HabitDataset
from ucon.lives.clock import N_SLOTS, day_and_slot, time_of
from ucon.lives.life import Life, Move, Request

#: Probability that a possession is used in a slot, and that it is then left at a place by mistake.
USED, MISTAKEN = 0.35, 0.05
REQUESTS_A_DAY = 4
#: Most days with an occasion.
MOST_OCCASIONS = 2
#: Tries to find a possession that can be asked for.
_TRIES = 40


@dataclass(frozen=True)
class Calendar:
    """When a life takes place.

    Attributes:
        first_weekday: weekday of day 0: 0 (Monday) to 6.
        season: season of all days.
        occasions: (day, occasion) for each day that has an occasion.
    """

    first_weekday: int
    season: str
    occasions: tuple[tuple[int, str], ...]


def drawn_calendar(days: int, occasions: Sequence[str], rng: np.random.Generator) -> Calendar:
    """A random calendar.

    Args:
        days: length of the life.
        occasions: occasions that matter to the household.
        rng: random numbers.
    """
    season = SEASONS[int(rng.integers(len(SEASONS)))]
    fitting = [name for name in sorted(occasions) if season_of(name) in (None, season)]
    count = min(int(rng.integers(MOST_OCCASIONS + 1)), len(fitting), days)
    on = sorted(int(day) for day in rng.choice(days, count, replace=False))
    what = [fitting[int(k)] for k in rng.choice(len(fitting), count, replace=False)] if count else []
    return Calendar(int(rng.integers(7)), season, tuple(zip(on, what, strict=True)))


class Days:
    """Simulates the people of one life."""

    def __init__(self, life: Life, dataset: HabitDataset) -> None:
        """Take a life without moves and requests.

        Args:
            life: has possessions, places, people and calendar.
            dataset: the habits with which it is made.
        """
        self.life = life
        self._entries = {name: dataset.entries[dataset.entry_number[name]] for name in _entries_of(life)}

    def first_places(self) -> tuple[int, ...]:
        """Where everything is before the first morning, as put there on the evening before."""
        count = len(self.life.possessions)
        return tuple(self._first(k, stream(self.life.seed, "life", "first", k)) for k in range(count))

    def moves(self) -> tuple[Move, ...]:
        """What people put somewhere else, in order of time; uses that leave a thing at its place are left out."""
        life, now = self.life, list(self.life.at_first)
        found: list[Move] = []
        for time in range(N_SLOTS * life.days):
            for k in range(len(life.possessions)):
                rng = stream(life.seed, "life", "use", time, k)
                if rng.random() >= USED:
                    continue
                place, user = self._put(k, *day_and_slot(time), rng)
                if place is not None and place != now[k]:
                    found.append(Move(time, k, place, user))
                    now[k] = place
        return tuple(found)

    def requests(self, wanted: Sequence[int], can_be_found: Callable[[int, int], bool]) -> tuple[Request, ...]:
        """What the robot is asked for, in order of time: some things often, others rarely (Zipf).

        Nothing is asked for twice in a slot.

        Args:
            wanted: numbers of the possessions that may be asked for.
            can_be_found: maps (possession, time) to whether a robot can find the possession then.

        Raises:
            EpisodeError: hardly anything can be found.
        """
        life = self.life
        order = stream(life.seed, "life", "zipf").permutation(np.array(wanted))
        weight = 1.0 / np.arange(1, len(order) + 1)
        found: list[Request] = []
        for day in range(life.days):
            rng = stream(life.seed, "life", "ask", day)
            for slot in sorted(int(slot) for slot in rng.integers(N_SLOTS, size=REQUESTS_A_DAY)):
                time = time_of(day, slot)
                asked = {one.possession for one in found if one.time == time}
                found.append(self._request(time, order, weight * ~np.isin(order, list(asked)), can_be_found, rng))
        return tuple(found)

    def _request(
        self,
        time: int,
        order: NDArray[np.int64],
        weight: NDArray[np.float64],
        can_be_found: Callable[[int, int], bool],
        rng: np.random.Generator,
    ) -> Request:
        for _ in range(_TRIES):
            k = int(rng.choice(order, p=weight / weight.sum()))
            user = int(rng.integers(self.life.users))
            people = self._people(k, day_and_slot(time)[0], user)
            person = people[int(rng.integers(len(people)))] if people else None
            if can_be_found(k, time):
                return Request(time, k, user, person)
        raise EpisodeError(f"{self.life.scene}: nothing can be found at time {time}; use another seed")

    def _people(self, possession: int, day: int, user: int) -> list[str]:
        """Names of the people on whom placements of a user's entry depend."""
        entry = self._entries[self.life.entry_of(possession, day, user)]
        conditions = [condition_of(place.context) for place in entry.placements if place.context]
        return sorted({one.user for one in conditions if one.user})

    def _first(self, possession: int, rng: np.random.Generator) -> int:
        """Where a possession is put on the evening before; any place it is kept at if no condition holds then."""
        place, _ = self._put(possession, 0, N_SLOTS - 1, rng)
        places = self.life.possessions[possession].places
        kept = [n for n, one in enumerate(places) if any(name in self._at_first(possession) for name, _ in one.origins)]
        return kept[int(rng.integers(len(kept)))] if place is None else place

    def _at_first(self, possession: int) -> tuple[str, ...]:
        return self.life.possessions[possession].entries

    def _put(self, possession: int, day: int, slot: int, rng: np.random.Generator) -> tuple[int | None, int]:
        """Place where a used possession is put (None: it stays where it is), and the user (-1: a mistake)."""
        user = int(rng.integers(self.life.users))
        people = self._people(possession, day, user)
        person = people[int(rng.integers(len(people)))] if people else None
        places = self.life.possessions[possession].places
        strays = [n for n, place in enumerate(places) if not place.origins]
        if rng.random() < MISTAKEN and strays:
            return strays[int(rng.integers(len(strays)))], -1
        entry = self._entries[self.life.entry_of(possession, day, user)]
        context = self.life.context(day, slot, entry.household, person)
        holding: list[int] = []
        always: list[int] = []
        for n, place in enumerate(places):
            for index in {index for name, index in place.origins if name == entry.id}:
                said = entry.placements[index].context
                if said is None:
                    always.append(n)
                elif condition_of(said).holds(context):
                    holding.append(n)
        usual = sorted(set(holding)) or sorted(set(always))
        return (usual[int(rng.integers(len(usual)))] if usual else None), user


def lived(life: Life, dataset: HabitDataset) -> Life:
    """The life with first places and moves."""
    life = replace(life, at_first=Days(life, dataset).first_places())
    return replace(life, moves=Days(life, dataset).moves())


def _entries_of(life: Life) -> set[str]:
    return {name for one in life.possessions for name in (*one.entries, *one.later)}
