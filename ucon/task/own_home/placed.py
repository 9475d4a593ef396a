"""Shared by both ways of placing requests: the result, the spots of places, and whether a place is possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ucon.core.errors import PlacementError
from ucon.core.rng import stream
from ucon.habits.types import HabitDataset, Placement
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.placement import importable, place
from ucon.sim.placement.spot import ANYWHERE, Spot
from ucon.task.episode import Episode
from ucon.task.making.draft import instances_of
from ucon.task.making.own_household import OwnPlacement
from ucon.task.making.sampler import Spots
from ucon.task.own_home.building import rooms_by_name
from ucon.task.own_home.wish import OwnHome, Request


@dataclass(frozen=True)
class Placed:
    """A request that was placed.

    Attributes:
        request: what was asked for.
        place: where the thing is kept; the first of several places.
        chance: probability of this place given the habits; None if the home file names the place.
        episodes: one for each start.
    """

    request: Request
    place: Placement
    chance: float | None
    episodes: tuple[Episode, ...]


def as_asked(request: Request, name: str) -> OwnPlacement:
    """Convert a request to one of a user's own household.

    Args:
        request: the request.
        name: name of the home.
    """
    return OwnPlacement(name, request.target, tuple(one.text for one in request.habits), request.place)


def spots_of(wish: OwnHome, house: House) -> Spots:
    """What the home file states about places besides relation and anchor.

    Args:
        wish: the home as its file describes it.
        house: the home as built.
    """
    numbers = {room.name: number for number, room in enumerate(house.spec.rooms)}
    by_call = {called: numbers[name] for name, called in reversed(rooms_by_name(wish, house).items())}
    return {
        (one.target, said.placement.relation, said.placement.anchor): spot
        for one in (*wish.requests, *wish.things)
        for said in one.places
        if (spot := Spot(said.side, said.facing, None if said.room is None else by_call[said.room])) != ANYWHERE
    }


def refusal(house: House, target: str, there: Placement, spot: Spot = ANYWHERE) -> str | None:
    """Why a thing cannot be put at a place of the home as it is built; None where it can.

    Args:
        house: the home.
        target: category of the thing.
        there: relation and anchor.
        spot: what else is stated about the place.
    """
    bare = Arrangement(removed=instances_of(house, [target]))
    anchors = [k for k, one in enumerate(house.categories) if one == there.anchor and k not in bare.removed]
    thing = there.anchor.replace("_", " ")
    if spot.room is not None:
        anchors = [k for k in anchors if house.instance_room[k] == spot.room]
        if not anchors:
            return f"no {thing} stands in that room"
    if not anchors:
        return None if importable(there.anchor) else f"no {thing} stands in this home"
    reason = ""
    for instance in anchors:
        try:
            place(house, bare, target, there.relation, instance, stream(0, "own home", target, instance), spot)
        except PlacementError as error:
            reason = str(error)
        else:
            return None
    return reason


def of_all(episodes: Sequence[Episode], own: Sequence[str], dataset: HabitDataset) -> tuple[Episode, ...]:
    """Give episodes the habits of all requests, so that each knowledge base has every sentence of the home file.

    Their ids end in a hash of their content, so that a changed file visibly gives other episodes.

    Args:
        episodes: the episodes of one request.
        own: ids of the entries from the home file.
        dataset: all habits.
    """
    whole = [
        replace(one, entries=tuple(dict.fromkeys((*own, *one.entries))), habits_hash=dataset.sha256) for one in episodes
    ]
    return tuple(replace(one, id=f"{one.id}/{one.hash[:8]}") for one in whole)
