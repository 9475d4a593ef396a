"""The plausible (target, relation, anchor) triples of the official data, and houses to try them in."""

from __future__ import annotations

import csv
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import pytest

from ucon.core.rng import stream
from ucon.scenes import SCENES, home_spec
from ucon.sim.arrangement import Arrangement
from ucon.sim.compile import compile_house
from ucon.sim.house import House
from ucon.sim.placement import RefusedError, import_anchor, importable, place, with_object

FACTS = Path(__file__).resolve().parents[2] / "../shared/facts/relations_triples.csv"
ANCHORS_TRIED = 8


class Triple(NamedTuple):
    target: str
    relation: str
    anchor: str


@lru_cache(maxsize=1)
def triples() -> tuple[Triple, ...]:
    if not FACTS.is_file():
        pytest.skip("the facts about the official data are not part of the repository")
    with FACTS.open() as file:
        rows = [row for row in csv.DictReader(file) if row["verdict"] == "ok"]
    return tuple(Triple(row["target"], row["relation"], row["anchor"]) for row in rows)


@lru_cache(maxsize=len(SCENES))
def house_of(name: str) -> House:
    return compile_house(home_spec(name), check=False)


def sample(relation: str, count: int, scenes: tuple[str, ...]) -> list[tuple[Triple, str]]:
    """Triples of a relation, each with a scene that has the anchor; ``count`` of them, or all if it is 0."""
    has = {name: set(house_of(name).categories) for name in scenes}
    usable = []
    for number, triple in enumerate(t for t in triples() if t.relation == relation):
        homes = [name for name in scenes if triple.anchor in has[name]]
        if homes:
            usable.append((triple, homes[number % len(homes)]))
    if not count:
        return usable
    chosen = stream(0, "triples", relation).choice(len(usable), min(count, len(usable)), replace=False)
    return [usable[k] for k in sorted(chosen)]


def try_triple(triple: Triple, name: str, arrangement: Arrangement | None = None):
    """The placed object, or the reason why it could not be placed at any of the first few anchors."""
    house, before = house_of(name), arrangement or Arrangement()
    anchors = [i for i, category in enumerate(house.categories) if category == triple.anchor]
    order = stream(0, name, *triple).permutation(len(anchors))
    reason = "absent_anchor"
    for k in order[:ANCHORS_TRIED]:
        try:
            rng = stream(0, name, *triple, int(anchors[k]))
            return place(house, before, triple.target, triple.relation, anchors[k], rng)
        except RefusedError as error:
            reason = error.reason
    return reason


def with_imported(name: str, category: str):
    """An arrangement with one imported anchor and its instance number; None if it cannot be imported."""
    house = house_of(name)
    if not importable(category):
        return None
    placed = import_anchor(house, Arrangement(), category, stream(0, "import", name, category))
    return with_object(house, Arrangement(), placed), house.n_instances
