"""Where a target is kept, in words, from the household's own placement."""

from __future__ import annotations

import pytest

from ucon.habits import book
from ucon.sim.cache import load_house
from ucon.task.sets import load_episodes
from ucon.task.spoken import spoken_place, target_place


def test_it_is_the_place_of_the_household() -> None:
    dataset, relations = book(), set()
    for episode in load_episodes("mini"):
        entry, number = episode.placed_by[episode.target]
        place = dataset.entries[dataset.entry_number[entry]].placements[number]
        assert target_place(episode) == spoken_place(place.relation, place.anchor)
        relations.add(place.relation)
    assert relations >= {"inside", "ontop", "nextto"}


def test_an_anchor_may_be_brought_in_with_the_episode() -> None:
    brought = [
        episode
        for episode in load_episodes("mini")
        if episode.target_object.anchor >= load_house(episode.scene).n_instances
    ]
    assert brought


@pytest.mark.parametrize(
    ("relation", "anchor", "said"),
    [
        ("inside", "fridge", "in the fridge"),
        ("ontop", "dining_table", "on the dining table"),
        ("under", "bed", "under the bed"),
        ("nextto", "laptop", "beside the laptop"),
        ("imported", "floors", "on the floor"),
    ],
)
def test_words(relation: str, anchor: str, said: str) -> None:
    assert spoken_place(relation, anchor) == said
