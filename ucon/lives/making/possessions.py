"""The things of a household: which ones there are, whose habits they follow, and which habits change."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ucon.habits.contexts import condition_of
from ucon.habits.hosting import Hosted, hosted
from ucon.habits.splits import Split, entry_filter
from ucon.habits.types import HabitDataset
from ucon.sim.house import House
from ucon.sim.placement import importable
from ucon.task.making.draft import bearing_categories
from ucon.task.making.living import contradictory, home_kinds, living_in

#: Share of things whose habits name different places in different contexts, as far as the dataset has so many.
CONTRADICTORY = 0.3


@dataclass(frozen=True, eq=False)
class Owned:
    """A possession before its places are found.

    Attributes:
        category: category of the thing.
        hosts: its entries, at most one for each user and in their order, with the placements the home can realise.
        other: a further entry, for the day of a change; None if there is none.
        elsewhere: entries of other households; their placements are plausible, but not this household's.
    """

    category: str
    hosts: tuple[Hosted, ...]
    other: Hosted | None
    elsewhere: tuple[Hosted, ...]

    def to_change(self) -> Owned | None:
        """The thing prepared for a change, if need be to its own last entry; None if it has only one entry."""
        if self.other is None and len(self.hosts) > 1:
            return replace(self, hosts=self.hosts[:-1], other=self.hosts[-1])
        return None if self.other is None else self

    @property
    def contradictory(self) -> bool:
        """Whether habits of one entry support placements that are never used in the same context."""
        return any(contradictory(host.entry) for host in self.hosts)

    @property
    def occasions(self) -> set[str]:
        """Occasions on which placements of the entries depend."""
        places = [place for host in self.hosts for place in host.placements if place.context]
        return {occasion for place in places if (occasion := condition_of(str(place.context)).occasion)}


def candidates(
    house: House, dataset: HabitDataset, part: Split, users: int, wanted: Collection[str], rng: np.random.Generator
) -> list[Owned]:
    """Things that the household of a home may own, in random order, those that may be requested first.

    Args:
        house: the home.
        dataset: the habits.
        part: part of the habits whose entries may be used.
        users: number of people.
        wanted: categories that requests may be for.
        rng: decides order and entries.
    """
    living, usable = living_in(house, dataset, part), entry_filter(dataset, part)
    kinds, present, home = home_kinds(house.spec), set(house.categories), house.spec.name
    never, found = bearing_categories(house), []
    for name in (str(name) for name in rng.permutation(sorted(living))):
        if name in never:
            continue
        hosts = tuple(host for host in living[name] if host.ok)[:users]
        own = {host.entry.id for host in living[name]}
        free = [
            entry
            for entry in dataset.entries_of(name)
            if entry.id not in own and (entry.kind is None or entry.kind in kinds)
        ]
        others = [
            host
            for host in hosted(free, present, importable, home=home, verdicts=dataset.verdicts)
            if host.ok and host.realisable
        ]
        order = [others[int(k)] for k in rng.permutation(len(others))]
        other = next((host for host in order if usable(host.entry)), None)
        found.append(Owned(name, hosts, other, tuple(host for host in order if host is not other)))
    return sorted(found, key=lambda owned: owned.category not in wanted)


def chosen(found: Sequence[Owned], count: int) -> tuple[list[Owned], list[Owned]]:
    """Choose the first things such that for a share of them the place depends on day, hour, season, occasion or user.

    Args:
        found: candidates in order.
        count: number of things.

    Returns:
        The chosen things, and the others in order.
    """
    some = [owned for owned in found if owned.contradictory][: round(CONTRADICTORY * count)]
    rest = [owned for owned in found if owned not in some]
    missing = count - len(some)
    return [*some, *rest[:missing]], rest[missing:]


def wanted_anchors(things: Sequence[Owned]) -> list[str]:
    """Anchor categories of the things' placements, those with most placements first."""
    every = [place.anchor for thing in things for host in thing.hosts for place in host.placements]
    counts = Counter(every)
    return sorted(counts, key=lambda name: (-counts[name], name))
