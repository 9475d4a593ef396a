"""The requests of a home of one's own as episodes: each thing is put where it is said, or where the habits say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from ucon.core.errors import EpisodeError, PlacementError, brief
from ucon.core.rng import stream
from ucon.habits.book import Faults, book_anchors
from ucon.habits.rules import placement_fault
from ucon.habits.types import Entry, HabitDataset, Placement
from ucon.objects.model import RELATIONS
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.placement import importable, place
from ucon.task.episode import Episode
from ucon.task.making.draft import instances_of
from ucon.task.making.own_household import (
    OwnPlacement,
    ReadPlaces,
    likely_places,
    others_of,
    own_entry,
    own_household,
)
from ucon.task.making.sampler import EpisodeSampler
from ucon.task.own_home.reading import raise_in_order
from ucon.task.own_home.wish import OwnHome, Request
from ucon.task.rules import TaskRules
from ucon.task.spoken import spoken_place

#: Seeds that are tried for each start.
_SEEDS_A_START: Final = 3
#: Places that are tried for a thing that cannot be put where it was said.
_NEAR: Final = 12


@dataclass(frozen=True)
class Placed:
    """A request that was placed.

    Attributes:
        request: what was asked for.
        place: where the thing is kept.
        chance: probability of this place by the habits; None where the place was said.
        episodes: one for each start.
    """

    request: Request
    place: Placement
    chance: float | None
    episodes: tuple[Episode, ...]


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

    The other things of the home are kept by households of the habit book, whose sentences the robot is told, too.

    Args:
        wish: the home.
        name: its name.
        house: what was built.
        read: reads the habits.
        rules: rule set under which the episodes must be solvable.
        seed: of the first start of each request.
        faults: that were found before; they are told, too.

    Returns:
        The requests in their order, and the habits that all their episodes belong to.

    Raises:
        DataError: something cannot be placed; one line for each, with the nearest place that can be.
    """
    others = others_of(name, [request.target for request in wish.requests])
    faults, found = faults or Faults(), []
    for request in wish.requests:
        try:
            found.append(_placed(request, name, house, others, read, rules, range(seed, seed + wish.starts)))
        except PlacementError as error:
            faults.add(request.where, str(error))
    raise_in_order(faults, Path(wish.file))
    dataset = own_household({_asked(one.request, name): one.place for one in found}, others)
    own = tuple(own_entry(one.request.target) for one in found)
    return tuple(replace(one, episodes=_of_all(one.episodes, own, dataset)) for one in found), dataset


def _asked(request: Request, name: str) -> OwnPlacement:
    return OwnPlacement(name, request.target, tuple(one.text for one in request.habits), request.place)


def _of_all(episodes: Sequence[Episode], own: Sequence[str], dataset: HabitDataset) -> tuple[Episode, ...]:
    """Episodes that belong to the habits of all requests: every sentence of the owner is known in each.

    Their ids end in a hash of what they are, so that a changed file is seen to have other episodes.
    """
    whole = [
        replace(one, entries=tuple(dict.fromkeys((*own, *one.entries))), habits_hash=dataset.sha256) for one in episodes
    ]
    return tuple(replace(one, id=f"{one.id}/{one.hash[:8]}") for one in whole)


def _placed(
    request: Request,
    name: str,
    house: House,
    others: Sequence[Entry],
    read: ReadPlaces,
    rules: TaskRules,
    seeds: range,
) -> Placed:
    """One request at the first place that works.

    Raises:
        PlacementError: no place works.
    """
    asked, reasons = _asked(request, name), []
    for there, chance in likely_places(asked, read):
        reason = _refusal(house, request.target, there)
        if reason is None:
            dataset = own_household({asked: there}, others)
            episodes = list(_episodes(EpisodeSampler(dataset, rules=rules), name, request.target, seeds))
            if len(episodes) == len(seeds):
                return Placed(request, there, None if request.place else chance, tuple(episodes))
            reason = f"found from {len(episodes)} of {len(seeds)} starts there"
        reasons.append(reason)
    thing = request.target.replace("_", " ")
    where = spoken_place(request.place.relation, request.place.anchor) if request.place else "where the habits say"
    why = reasons[0] if reasons else "they name no place in this home"
    near = next(_near(asked, house, read), None)
    hint = f"; {spoken_place(near.relation, near.anchor)} it can" if near else "; ask for something smaller"
    raise PlacementError(f"the {thing} cannot be kept {where} ({brief(why)}){hint}")


def _episodes(sampler: EpisodeSampler, name: str, target: str, seeds: range) -> Iterator[Episode]:
    """One episode for each seed, or for later ones where a seed gives none."""
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


def _refusal(house: House, target: str, there: Placement) -> str | None:
    """Why a thing cannot be put at a place of the home as it is built; None where it can."""
    bare = Arrangement(removed=instances_of(house, [target]))
    anchors = [k for k, one in enumerate(house.categories) if one == there.anchor and k not in bare.removed]
    if not anchors:
        thing = there.anchor.replace("_", " ")
        return None if importable(there.anchor) else f"no {thing} stands in this home"
    reason = ""
    for instance in anchors:
        try:
            place(house, bare, target, there.relation, instance, stream(0, "own home", target, instance))
        except PlacementError as error:
            reason = str(error)
        else:
            return None
    return reason


def _near(asked: OwnPlacement, house: House, read: ReadPlaces) -> Iterator[Placement]:
    """Places of the home that take a thing: first by the same anchor, then those that its habits speak of."""
    said = asked.place
    same = [Placement(relation, said.anchor) for relation in RELATIONS] if said else []
    likely = [there for there, _ in likely_places(replace(asked, place=None), read)]
    for there in [*same, *likely][:_NEAR]:
        allowed = placement_fault(asked.target, [], there, book_anchors()) is None and there.anchor in house.categories
        if there != said and allowed and _refusal(house, asked.target, there) is None:
            yield there
