"""Verifies a life: it fits its home, its places fit together, people follow their habits, every request can be met."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ucon.core.errors import UconError
from ucon.habits.contexts import condition_of
from ucon.habits.types import Entry, HabitDataset
from ucon.lives.asking import Asking
from ucon.lives.check_life import check_life_home
from ucon.lives.clock import day_and_slot
from ucon.lives.life import Life, Move, Place
from ucon.lives.meeting import meet, object_boxes
from ucon.sim.cache import load_house


def verify_life(life: Life, dataset: HabitDataset) -> list[str]:
    """What is wrong with a life; [] if nothing is wrong.

    Args:
        life: the life.
        dataset: the habits with which it was made.
    """
    try:
        check_life_home(life, load_house(life.scene))
        asking = Asking(life, dataset)
    except UconError as error:
        return [str(error)]
    return [*_meeting(life), *_strange_moves(life, dataset), *_unmet(asking)]


def _meeting(life: Life) -> Iterator[str]:
    """Pairs of possessions with places that touch each other."""
    boxes = [np.concatenate([object_boxes(place.object) for place in one.places]) for one in life.possessions]
    for (a, mine), (b, others) in combinations(enumerate(boxes), 2):
        if meet(mine, others):
            yield f"places of {life.possessions[a].category} and {life.possessions[b].category} overlap"


def _strange_moves(life: Life, dataset: HabitDataset) -> Iterator[str]:
    """Moves to a place that the user's entry does not name at that time."""
    for number, move in enumerate(life.moves):
        day, _ = day_and_slot(move.time)
        place = life.possessions[move.possession].places[move.place]
        if move.user < 0:
            if place.origins:
                yield f"move {number}: marked as a mistake, but to a place where the thing is kept"
            continue
        name = life.entry_of(move.possession, day, move.user)
        entry = dataset.entries[dataset.entry_number[name]]
        if not _may_be(life, move, place, entry):
            yield f"move {number}: entry {name} does not name this place at that time"


def _may_be(life: Life, move: Move, place: Place, entry: Entry) -> bool:
    """Whether an entry has a placement at this place whose condition holds for somebody at the time of a move."""
    conditions = [condition_of(text) for one in entry.placements if (text := one.context)]
    people = [None, *sorted({one.user for one in conditions if one.user})]
    contexts = [life.context(*day_and_slot(move.time), entry.household, person) for person in people]
    for name, index in place.origins:
        if name == entry.id:
            said = entry.placements[index].context
            if said is None or any(condition_of(said).holds(context) for context in contexts):
                return True
    return False


def _unmet(asking: Asking) -> Iterator[str]:
    """Requests that cannot be met from the dock."""
    for number in range(len(asking.life.requests)):
        try:
            asking.episode(number, asking.standing(number, asking.life.dock))
        except UconError as error:
            yield str(error)
