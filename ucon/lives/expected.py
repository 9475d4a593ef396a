"""Where a possession is to be expected: what an observer could know who knows all habits and rules of use exactly.

Such an observer knows how each person keeps the thing, how often things are used and mislaid, and where it was last
seen, but nothing that has happened since. Privileged: no agent is given these rules.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.habits.contexts import condition_of
from ucon.habits.types import HabitDataset
from ucon.lives.clock import day_and_slot
from ucon.lives.life import Life
from ucon.lives.making.days import MISTAKEN, USED

Array = NDArray[np.float64]


def expected_places(
    life: Life, dataset: HabitDataset, possession: int, time: int, seen: tuple[int, int] | None
) -> Array:
    """Probability (P,) of each place of a possession at a time.

    Args:
        life: the life.
        dataset: the habits with which the life was made.
        possession: number of the possession.
        time: time of the request.
        seen: time and place at which it was last seen; None: never, so it began where its first entries keep it.
    """
    places = life.possessions[possession].places
    if seen is None:
        own = set(life.possessions[possession].entries)
        kept = np.array([any(name in own for name, _ in place.origins) for place in places], np.float64)
        last, p = -1, kept / kept.sum()
    else:
        last, p = seen[0], np.eye(len(places))[seen[1]]
    for slot in range(last + 1, time + 1):
        put, stays = _put(life, dataset, possession, slot)
        p = (1.0 - USED) * p + USED * (put + stays * p)
    return np.asarray(p, np.float64)


def _put(life: Life, dataset: HabitDataset, possession: int, time: int) -> tuple[Array, float]:
    """Probability (P,) of where a possession used at a time is put, and the probability that it stays where it is."""
    places, (day, slot) = life.possessions[possession].places, day_and_slot(time)
    strays = np.array([not place.origins for place in places], np.float64)
    mistaken = MISTAKEN if strays.any() else 0.0
    put, stays = mistaken * strays / max(strays.sum(), 1.0), 0.0
    for user in range(life.users):
        entry = dataset.entries[dataset.entry_number[life.entry_of(possession, day, user)]]
        said = [condition_of(place.context) for place in entry.placements if place.context]
        people: list[str | None] = [*sorted({one.user for one in said if one.user})] or [None]
        share = (1.0 - mistaken) / (life.users * len(people))
        for person in people:
            context = life.context(day, slot, entry.household, person)
            holding, always = np.zeros(len(places), bool), np.zeros(len(places), bool)
            for number, place in enumerate(places):
                for index in (index for name, index in place.origins if name == entry.id):
                    when = entry.placements[index].context
                    holding[number] |= when is not None and condition_of(when).holds(context)
                    always[number] |= when is None
            usual = holding if holding.any() else always
            if usual.any():
                put = put + share * usual / usual.sum()
            else:
                stays += share
    return put, stays
