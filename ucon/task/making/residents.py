"""The household of a home, for display: which placements can be realised there, and why others cannot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ucon.habits.hosting import MIN_REALISABLE, Hosted, hosted, household
from ucon.habits.types import HabitDataset
from ucon.sim.house import House
from ucon.sim.placement import importable
from ucon.task.making.draft import bearing_categories
from ucon.task.making.living import home_kinds

IMPORTED = "imported"
"""Note of a placement whose anchor is not in the home but can be added."""
BEARING = "supports other things in the home, so it is never moved"
UNHOSTED = f"no entry with {MIN_REALISABLE} placements that can be realised"


@dataclass(frozen=True)
class Resident:
    """The household's entries of one category in a home."""

    category: str
    hosts: tuple[Hosted, ...]
    """The entries, with their realisable placements."""
    notes: Mapping[tuple[str, int], str]
    """By entry id and placement index: why it cannot be realised, or :data:`IMPORTED`; no key where all is well."""
    refusal: str | None
    """Why the category is never a target here; None where it may be one."""


def residents(house: House, dataset: HabitDataset, seed: int = 0) -> list[Resident]:
    """The household of a home by category, with reasons.

    Agrees with :func:`ucon.task.making.living.living_in` on what can be sampled.

    Args:
        house: the home.
        dataset: the habits.
        seed: of the household; episodes use 0.
    """
    present, never = frozenset(house.categories), bearing_categories(house)
    home = house.spec.name
    found = []
    for category, entries in household(home, dataset, seed, kinds=home_kinds(house.spec)).items():
        hosts = tuple(hosted(entries, present, importable, home=home, verdicts=dataset.verdicts))
        refusal = BEARING if category in never else None if any(host.ok for host in hosts) else UNHOSTED
        notes = {
            (host.entry.id, index): note
            for host in hosts
            for index in range(len(host.entry.placements))
            if (note := _note(host, index, present, home, dataset))
        }
        found.append(Resident(category, hosts, notes, refusal))
    return found


def _note(host: Hosted, index: int, present: frozenset[str], home: str, dataset: HabitDataset) -> str | None:
    """Why a placement cannot be realised, :data:`IMPORTED`, or None."""
    place = host.entry.placements[index]
    if index in host.realisable:
        return None if place.anchor in present else IMPORTED
    if place.anchor not in present and not importable(place.anchor):
        return "absent_anchor"
    return dataset.verdicts.refusal((host.entry.category, place.relation, place.anchor), home)
