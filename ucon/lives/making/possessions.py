"""The things of a household: which ones, by whose habits they are kept, and what changes."""

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

#: Least share of the things whose habits contradict each other by context, where the dataset has so many.
CONTRADICTORY = 0.3


@dataclass(frozen=True, eq=False)
class Owned:
    """A possession before its places are found.

    Attributes:
        category: of the thing.
        hosts: its entries, one for each user and in their order, and the placements that the home can realise.
        other: an entry that is not among them, for the day of a change; None where there is none.
        elsewhere: entries of other households; their placements are plausible, and not this household's.
    """

    category: str
    hosts: tuple[Hosted, ...]
    other: Hosted | None
    elsewhere: tuple[Hosted, ...]

    def to_change(self) -> Owned | None:
        """The thing if it is to change: without another entry its last one is kept for that. None if it has but one."""
        if self.other is None and len(self.hosts) > 1:
            return replace(self, hosts=self.hosts[:-1], other=self.hosts[-1])
        return None if self.other is None else self

    @property
    def contradictory(self) -> bool:
        """Whether one of the entries speaks for places that no context has both."""
        return any(contradictory(host.entry) for host in self.hosts)

    @property
    def occasions(self) -> set[str]:
        """Occasions on which placements of the entries depend."""
        places = [place for host in self.hosts for place in host.placements if place.context]
        return {occasion for place in places if (occasion := condition_of(str(place.context)).occasion)}


def candidates(
    house: House, dataset: HabitDataset, part: Split, users: int, wanted: Collection[str], rng: np.random.Generator
) -> list[Owned]:
    """Things that the household of a home may own: those that requests may be for first, in random order.

    Args:
        house: the home.
        dataset: the habits.
        part: whose entries may be used.
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
    """Choose the first things so that a share of them is kept by day, hour, season, occasion or user.

    Args:
        found: candidates in order.
        count: of things.

    Returns:
        The chosen ones, and the others in order.
    """
    some = [owned for owned in found if owned.contradictory][: round(CONTRADICTORY * count)]
    rest = [owned for owned in found if owned not in some]
    missing = count - len(some)
    return [*some, *rest[:missing]], rest[missing:]


def wanted_anchors(things: Sequence[Owned]) -> list[str]:
    """Anchor categories of the things' placements, those of most placements first."""
    every = [place.anchor for thing in things for host in thing.hosts for place in host.placements]
    counts = Counter(every)
    return sorted(counts, key=lambda name: (-counts[name], name))
