"""Searches of a home that has only the home file's own habits: each day all its things are placed where these say.

This is how the paper's robot searched real homes: with hand-made habits, and things put where these say.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from ucon.core.errors import brief
from ucon.habits.book import Faults
from ucon.habits.types import Entry, Habit, HabitDataset, Placement
from ucon.language.lexicon import Lexicon
from ucon.sim.house import House
from ucon.sim.placement.spot import ANYWHERE
from ucon.task.episode import Episode
from ucon.task.making.own_household import HOUSEHOLD, NAME, ReadPlaces, likely_places, own_entry
from ucon.task.making.sampler import EpisodeSampler, Spots
from ucon.task.own_home.placed import Placed, as_asked, of_all, refusal, spots_of
from ucon.task.own_home.reading import raise_in_order
from ucon.task.own_home.wish import OwnHome, Request
from ucon.task.rules import TaskRules

#: Days that are tried for each day wanted.
_DAYS_A_START: Final = 3
#: Number of leading features of a match that stand for a whole name or synonym; the others stand for parts of one.
_WHOLE_NAMES: Final = 2


def placed_in_days(
    wish: OwnHome,
    name: str,
    house: House,
    read: ReadPlaces,
    rules: TaskRules,
    seed: int = 0,
    faults: Faults | None = None,
) -> tuple[tuple[Placed, ...], HabitDataset]:
    """Place all things of a home afresh on each day, and search each request on ``starts`` days.

    Args:
        wish: the home as its file describes it.
        name: its name.
        house: the home as built.
        read: reads the habits.
        rules: rule set under which the episodes must be solvable.
        seed: of the first day.
        faults: faults found before, which are reported too.

    Returns:
        The requests in their order, and the habits that all their episodes use.

    Raises:
        DataError: things cannot be placed or found; one line for each.
    """
    faults, spots = faults or Faults(), spots_of(wish, house)
    kept = {one.target: one for one in (*wish.requests, *wish.things)}
    found = {target: _places(one, name, house, kept, read, spots, faults) for target, one in kept.items()}
    raise_in_order(faults, Path(wish.file))
    places = {target: placements for target, (placements, _) in found.items()}
    dataset = HabitDataset(NAME, tuple(_entry(kept[target], placements) for target, placements in places.items()))
    sampler = EpisodeSampler(dataset, k=len(kept), rules=rules, spots=spots)
    episodes, failed = _search(sampler, name, [one.target for one in wish.requests], wish.starts, seed)
    for one in wish.requests:
        if (n := len(episodes[one.target])) < wish.starts:
            why = next((text for text in failed if text.startswith(f"{one.target} ")), "it could be found nowhere")
            thing = one.target.replace("_", " ")
            told = f"found on {n} of {wish.starts} days ({brief(why)}); give another place, or fewer things"
            faults.add(one.where, f"the {thing} is {told}")
    raise_in_order(faults, Path(wish.file))
    own = [entry.id for entry in dataset.entries]
    placed = tuple(
        Placed(one, places[one.target][0], found[one.target][1], of_all(episodes[one.target], own, dataset))
        for one in wish.requests
    )
    return placed, dataset


def _search(
    sampler: EpisodeSampler, name: str, targets: Sequence[str], starts: int, seed: int
) -> tuple[dict[str, list[Episode]], list[str]]:
    """Episodes by target, and failed placements. A target that cannot be found on one day is searched on another."""
    found: dict[str, list[Episode]] = {target: [] for target in targets}
    failed: list[str] = []
    for day in range(seed, seed + _DAYS_A_START * starts):
        wanted = [target for target in targets if len(found[target]) < starts]
        if not wanted:
            break
        episodes, failures = sampler.day(name, day, wanted)
        failed += failures
        for episode in episodes:
            found[episode.target_category].append(episode)
    return found, failed


def _places(
    one: Request,
    name: str,
    house: House,
    kept: dict[str, Request],
    read: ReadPlaces,
    spots: Spots,
    faults: Faults,
) -> tuple[list[Placement], float | None]:
    """Where a thing is kept, and if the habits decide, how likely they make it; an impossible place is a fault."""
    asked = as_asked(one, name)
    said = [place.placement for place in one.places]
    reasons = []
    for there, chance in [(place, None) for place in said] or likely_places(asked, read):
        spot = spots.get((one.target, there.relation, there.anchor), ANYWHERE)
        reason = None if there.anchor in kept else refusal(house, one.target, there, spot)
        if reason is None and not said:
            return [there], chance
        if reason is not None:
            reasons.append(reason)
    if reasons or not said:
        thing, where = one.target.replace("_", " "), "there" if said else "where the habits say"
        why = brief(reasons[0]) if reasons else "they name no place in this home"
        faults.add(one.where, f"the {thing} cannot be kept {where} ({why}); give another place")
    return said, None


def _entry(one: Request, places: Sequence[Placement]) -> Entry:
    """The entry for a thing's sentences and places. If several, a sentence supports those whose anchor it names."""
    lexicon = Lexicon(place.anchor for place in places)
    habits = []
    for habit in one.habits:
        numbers, features = lexicon.matches(habit.text)
        named = {int(k) for k, of_name in zip(numbers, features, strict=True) if of_name[:_WHOLE_NAMES].any()}
        supports = tuple(k for k, place in enumerate(places) if len(places) == 1 or lexicon.ids[place.anchor] in named)
        habits.append(Habit(habit.text, supports))
    return Entry(own_entry(one.target), one.target, HOUSEHOLD, tuple(places), tuple(habits))
