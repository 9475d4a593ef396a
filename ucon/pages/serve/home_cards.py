"""Cards of things: what a thing is, and what is kept there by the habits."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from functools import cached_property
from typing import Any

from ucon.habits import HabitDataset
from ucon.sim.house import House
from ucon.sim.state import SceneState


class Cards:
    """Says what can be kept at the things of a home, by the habits of a dataset."""

    def __init__(self, dataset: HabitDataset) -> None:
        """Make cards from a dataset.

        Args:
            dataset: the habits.
        """
        self._dataset = dataset

    @cached_property
    def _kept(self) -> Mapping[str, Counter[tuple[str, str]]]:
        """By anchor: how many entries keep a category in a relation to it."""
        found: dict[str, Counter[tuple[str, str]]] = defaultdict(Counter)
        for entry in self._dataset.entries:
            for relation, anchor in {(place.relation, place.anchor) for place in entry.placements}:
                found[anchor][relation, entry.category] += 1
        return found

    def card(self, house: House, thing: int) -> dict[str, Any]:
        """The card of a thing.

        Args:
            house: the home.
            thing: number of the item.

        Returns:
            ``category``, ``size_m`` (width, depth, height as it stands), ``bottom_m``, ``room``, ``openable``, and
            ``kept``: by relation, the categories that can be kept there in this home, those with most entries first.
        """
        item, box = house.spec.items[thing], house.boxes[thing]
        kept: dict[str, list[str]] = {}
        for (relation, category), _ in sorted(self._kept.get(item.category, Counter()).items(), key=_order):
            triple = (category, relation, item.category)
            if self._dataset.verdicts.refusal(triple, house.spec.name) is None:
                kept.setdefault(relation, []).append(category)
        room = house.spec.rooms[item.room]
        return {
            "thing": thing,
            "category": item.category,
            "size_m": [round(float(box[k + 3] - box[k]), 2) for k in range(3)],
            "bottom_m": round(float(box[2]), 2),
            "room": room.name,
            "openable": bool(SceneState(house).openable[thing]),
            "kept": kept,
        }


def _order(pair: tuple[tuple[str, str], int]) -> tuple[int, tuple[str, str]]:
    return -pair[1], pair[0]
