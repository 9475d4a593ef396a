"""Turns the requests of a user's own home into episodes, with each thing where the file or else its habits say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from ucon.core.errors import EpisodeError, PlacementError, brief
from ucon.habits.book import Faults, book_anchors
from ucon.habits.rules import placement_fault
from ucon.habits.types import Entry, HabitDataset, Placement
from ucon.objects.model import RELATIONS
from ucon.sim.house import House
from ucon.sim.placement.spot import ANYWHERE
from ucon.task.episode import Episode
from ucon.task.making.own_household import (
    OwnPlacement,
    ReadPlaces,
    likely_places,
    others_of,
    own_entry,
    own_household,
)
from ucon.task.making.sampler import EpisodeSampler, Spots
from ucon.task.own_home.days import placed_in_days
from ucon.task.own_home.placed import Placed, as_asked, of_all, refusal, spots_of
from ucon.task.own_home.reading import raise_in_order
from ucon.task.own_home.wish import OwnHome, Request
from ucon.task.rules import TaskRules
from ucon.task.spoken import spoken_place

#: Seeds that are tried for each start.
_SEEDS_A_START: Final = 3
#: Places that are tried for a thing that cannot be put where the home file says.
_NEAR: Final = 12


def placed_requests(
    wish: OwnHome,
    name: str,
    house: House,
    read: ReadPlaces,
    rules: TaskRules,
    seed: int = 0,
    faults: Faults | None = None,
) -> tuple[tuple[Placed, ...], HabitDataset]:
    """Place the requests of a home.

    Households of the habit book keep the other things of the home, and the robot is given their sentences too; or no
    other things are placed (:func:`ucon.task.own_home.days.placed_in_days`).

    Args:
        wish: the home as its file describes it.
        name: its name.
        house: the home as built.
        read: reads the habits.
        rules: rule set under which the episodes must be solvable.
        seed: of the first start of each request.
        faults: faults found before, which are reported too.

    Returns:
        The requests in their order, and the habits that all their episodes use.

    Raises:
        DataError: things cannot be placed; one line for each, with the nearest possible place.
    """
    if not wish.others:
        return placed_in_days(wish, name, house, read, rules, seed, faults)
    others = others_of(name, [request.target for request in wish.requests])
    spots = spots_of(wish, house)
    faults, found = faults or Faults(), []
    for request in wish.requests:
        try:
            found.append(_placed(request, name, house, others, read, rules, spots, range(seed, seed + wish.starts)))
        except PlacementError as error:
            faults.add(request.where, str(error))
    raise_in_order(faults, Path(wish.file))
    dataset = own_household({as_asked(one.request, name): one.place for one in found}, others)
    own = tuple(own_entry(one.request.target) for one in found)
    return tuple(replace(one, episodes=of_all(one.episodes, own, dataset)) for one in found), dataset


def _placed(
    request: Request,
    name: str,
    house: House,
    others: Sequence[Entry],
    read: ReadPlaces,
    rules: TaskRules,
    spots: Spots,
    seeds: range,
) -> Placed:
    """Place one request at the first place that works.

    Raises:
        PlacementError: no place works.
    """
    asked, reasons = as_asked(request, name), []
    for there, chance in likely_places(asked, read):
        spot = spots.get((request.target, there.relation, there.anchor), ANYWHERE)
        reason = refusal(house, request.target, there, spot)
        if reason is None:
            dataset = own_household({asked: there}, others)
            episodes = list(_episodes(EpisodeSampler(dataset, rules=rules, spots=spots), name, request.target, seeds))
            if len(episodes) == len(seeds):
                return Placed(request, there, None if request.place else chance, tuple(episodes))
            reason = f"found from {len(episodes)} of {len(seeds)} starts there"
        reasons.append(reason)
    thing = request.target.replace("_", " ")
    where = spoken_place(request.place.relation, request.place.anchor) if request.place else "where the habits say"
    why = reasons[0] if reasons else "they name no place in this home"
    near = next(_near(asked, house, read), None)
    hint = f"; it can be kept {spoken_place(near.relation, near.anchor)}" if near else "; ask for something smaller"
    raise PlacementError(f"the {thing} cannot be kept {where} ({brief(why)}){hint}")


def _episodes(sampler: EpisodeSampler, name: str, target: str, seeds: range) -> Iterator[Episode]:
    """One episode for each seed; later seeds replace those that give none."""
    left = len(seeds)
    for seed in range(seeds.start, seeds.start + _SEEDS_A_START * len(seeds)):
        if left == 0:
            return
        try:
            episode = sampler.sample(name, seed, targets=[target], episode_id=f"{name}/{target}/{seed}")
        except EpisodeError:
            continue
        if episode.placed_by[episode.target][0] == own_entry(target):
            left -= 1
            yield episode


def _near(asked: OwnPlacement, house: House, read: ReadPlaces) -> Iterator[Placement]:
    """Possible places for a thing in the home: first at the same anchor, then those that its habits suggest."""
    said = asked.place
    same = [Placement(relation, said.anchor) for relation in RELATIONS] if said else []
    likely = [there for there, _ in likely_places(replace(asked, place=None), read)]
    for there in [*same, *likely][:_NEAR]:
        allowed = placement_fault(asked.target, [], there, book_anchors()) is None and there.anchor in house.categories
        if there != said and allowed and refusal(house, asked.target, there) is None:
            yield there
