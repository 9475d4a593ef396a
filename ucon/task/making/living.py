"""The household of a home, and the placements that an episode may realise, in random order."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ucon.habits.contexts import Context, condition_of, draw_context
from ucon.habits.hosting import Hosted, hosted, household
from ucon.habits.splits import Split
from ucon.habits.types import HOUSEHOLD_KINDS, Entry, HabitDataset, Placement
from ucon.objects.model import Relation
from ucon.scenes.spec import HomeSpec
from ucon.sim.house import House
from ucon.sim.placement import importable
from ucon.task.making.draft import bearing_categories

#: The household's entries of each category that can be sampled in a home.
Living = Mapping[str, tuple[Hosted, ...]]
_OUTSIDE = frozenset({"garage", "sauna"})
#: Contexts that are drawn to find one in which a given placement is used.
_CONTEXTS_TRIED = 200


@dataclass(frozen=True)
class Drawn:
    """A placement that the sampler tries.

    Attributes:
        entry: id of the entry.
        index: index of the placement in the entry.
        relation: relation to the anchor.
        anchor: category of the anchor.
    """

    entry: str
    index: int
    relation: Relation
    anchor: str


def home_kinds(spec: HomeSpec) -> tuple[str, ...]:
    """The household kinds that a home counts as, such as ``house`` and ``garden``."""
    found = [spec.kind] if spec.kind in HOUSEHOLD_KINDS else []
    if any(room.outdoor or room.type in _OUTSIDE for room in spec.rooms):
        found.append("garden")
    return tuple(found)


def living_in(house: House, dataset: HabitDataset, part: Split | None = None) -> dict[str, tuple[Hosted, ...]]:
    """The household of a home by category, for the categories that can be sampled there.

    A category needs an entry with enough realisable placements; the habits of its other entries then belong to the
    household too. Categories that other items stand on are left out.

    Args:
        house: the home.
        dataset: the habits.
        part: draw the household from the entries that this part may use; None: from all.
    """
    present, never = frozenset(house.categories), bearing_categories(house)
    home = house.spec.name
    people = household(home, dataset, kinds=home_kinds(house.spec), part=part)
    living = {
        name: tuple(hosted(entries, present, importable, home=home, verdicts=dataset.verdicts))
        for name, entries in people.items()
        if name not in never
    }
    return {name: found for name, found in living.items() if any(h.ok for h in found)}


def any_placement(living: Living, name: str, rng: np.random.Generator) -> list[Drawn]:
    """All realisable placements of a category, whatever their context, in random order.

    Args:
        living: the household, from :func:`living_in`.
        name: the category.
        rng: decides the order.
    """
    drawn = [place for host in living[name] if host.ok for place in _all(host)]
    return [drawn[int(k)] for k in rng.permutation(len(drawn))]


def placement_now(living: Living, name: str, context: Context, rng: np.random.Generator) -> list[Drawn]:
    """The placements of one entry of a category that hold in a context, in random order.

    Placements whose context is fulfilled come before those without a context; those whose context is not fulfilled are
    left out. The asker's own entry is used where the category has one.

    Args:
        living: the household, from :func:`living_in`.
        name: the category.
        context: of the episode.
        rng: decides entry and order.
    """
    hosts = [host for host in living[name] if host.ok]
    own = [host for host in hosts if host.entry.household == context.asker]
    for host in [own[0]] if own else [hosts[int(k)] for k in rng.permutation(len(hosts))]:
        found = [place for group in _active(host, context) for place in _shuffled(group, rng)]
        if found:
            return found
    return []


def placements_of(
    house: House, dataset: HabitDataset, entries: Iterable[Entry], context: Context | None
) -> list[Placement]:
    """The placements from which the sampler draws for one category in a home.

    Args:
        house: the home.
        dataset: the habits.
        entries: the household's entries of the category.
        context: of the episode, or None.
    """
    hosts = hosted(entries, set(house.categories), importable, home=house.spec.name, verdicts=dataset.verdicts)
    ok = [host for host in hosts if host.ok]
    if context is None:
        return [place for host in ok for place in host.placements]
    own = [host for host in ok if host.entry.household == context.asker][:1] or ok
    groups = [next((group for group in _active(host, context) if group), []) for host in own]
    by_id = {host.entry.id: host.entry for host in own}
    return [by_id[drawn.entry].placements[drawn.index] for group in groups for drawn in group]


def occasions_of(living: Living, names: Iterable[str]) -> list[str]:
    """Occasions that the placements of some categories depend on, in alphabetical order."""
    places = [place for name in names for host in living[name] if host.ok for place in host.placements]
    found = {condition_of(place.context).occasion for place in places if place.context}
    return sorted(occasion for occasion in found if occasion)


def drawn_context(
    living: Living, names: Sequence[str], target: str, rng: np.random.Generator, *, even: bool = False
) -> Context:
    """A random context for an episode: the asker uses the target, and the occasion matters to some placement.

    Args:
        living: the household, from :func:`living_in`.
        names: categories to be placed.
        target: the category to be found.
        rng: random numbers.
        even: first draw one of the placements that the asker's entry uses in some context, then a context in which it
            is used, so that rare conditions hold as often as frequent ones.
    """
    hosts = [host for host in living[target] if host.ok]
    host = hosts[int(rng.integers(len(hosts)))]
    users = {condition_of(place.context).user for place in host.placements if place.context}
    occasions = occasions_of(living, [target]) or occasions_of(living, names)

    def drawn() -> Context:
        return draw_context(rng, occasions, host.entry.household, filter(None, users))

    if not even:
        return drawn()
    some = [drawn() for _ in range(_CONTEXTS_TRIED)]
    used = [_used(host, context) for context in some]
    wanted = sorted(set().union(*used))
    if not wanted:
        return some[0]
    place = wanted[int(rng.integers(len(wanted)))]
    return next(context for context, places in zip(some, used, strict=True) if place in places)


def contradictory(entry: Entry) -> bool:
    """Whether habits of an entry support two placements that are never used in the same context."""
    told = {k for habit in entry.habits for k in habit.supports}
    conditions = [
        condition_of(place.context) for k, place in enumerate(entry.placements) if place.context and k in told
    ]
    return any(one.excludes(other) for one, other in combinations(conditions, 2))


def _used(host: Hosted, context: Context) -> set[int]:
    """Indices of the placements that an entry uses in a context."""
    return {drawn.index for drawn in next((group for group in _active(host, context) if group), [])}


def _active(host: Hosted, context: Context) -> tuple[list[Drawn], list[Drawn]]:
    """Placements of an entry whose context is fulfilled, and those without a context."""
    fulfilled, always = [], []
    for place, drawn in zip(host.placements, _all(host), strict=True):
        if place.context is None:
            always.append(drawn)
        elif condition_of(place.context).holds(context):
            fulfilled.append(drawn)
    return fulfilled, always


def _all(host: Hosted) -> list[Drawn]:
    """The realisable placements of an entry."""
    places = host.entry.placements
    return [Drawn(host.entry.id, k, places[k].relation, places[k].anchor) for k in host.realisable]


def _shuffled(group: list[Drawn], rng: np.random.Generator) -> list[Drawn]:
    """The placements in random order."""
    return [group[int(k)] for k in rng.permutation(len(group))]
