"""Routes of the page *Habits*: the households of a home, their sentences, and where each can come true."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from starlette.routing import Route

from ucon.habits import HabitDataset
from ucon.habits.hosting import Hosted
from ucon.pages.serve.answers import asked, whole
from ucon.pages.serve.homes import home_of
from ucon.sim.house import House
from ucon.task.making.residents import IMPORTED, Resident, residents

#: Largest seed of a household.
_MOST_SEED: Final = 10**6


def habit_routes(dataset: HabitDataset) -> list[Route]:
    """Routes of the page.

    Args:
        dataset: the habits.
    """

    def household(words: Mapping[str, Any]) -> dict[str, Any]:
        return household_of(home_of(words), dataset, whole(words, "seed", 0, _MOST_SEED, 0))

    return [asked("/api/habits/household", household)]


def household_of(house: House, dataset: HabitDataset, seed: int = 0) -> dict[str, Any]:
    """The people of a home as plain values.

    Args:
        house: the home.
        dataset: the habits.
        seed: each seed gives other people; 0 gives those of the episodes.

    Returns:
        ``labelled``: whether it is known which sentence is about which place; ``things``: by anchor category, the
        numbers of the home's things; ``entries``: one per household and category, with ``places`` and ``habits``.
    """
    things: dict[str, list[int]] = {}
    for number, item in enumerate(house.spec.items):
        things.setdefault(item.category, []).append(number)
    people = residents(house, dataset, seed)
    entries = [_entry(host, resident) for resident in people for host in resident.hosts]
    anchors = {place["anchor"] for entry in entries for place in entry["places"]}
    return {
        "home": house.spec.name,
        "dataset": dataset.name,
        "labelled": dataset.labelled,
        "things": {name: numbers for name, numbers in things.items() if name in anchors},
        "entries": entries,
    }


def _entry(host: Hosted, resident: Resident) -> dict[str, Any]:
    """An entry; ``refusal`` says why nothing of its category is ever searched for in this home."""
    entry = host.entry
    notes = [resident.notes.get((entry.id, k)) for k in range(len(entry.placements))]
    return {
        "category": entry.category,
        "household": entry.household,
        "refusal": resident.refusal,
        "places": [
            {
                "relation": place.relation,
                "anchor": place.anchor,
                "context": place.context,
                "here": k in host.realisable,
                "brought": note == IMPORTED,
                "why_not": None if k in host.realisable else note or "not possible here",
            }
            for k, (place, note) in enumerate(zip(entry.placements, notes, strict=True))
        ],
        "habits": [[habit.text, list(habit.supports)] for habit in entry.habits],
    }
