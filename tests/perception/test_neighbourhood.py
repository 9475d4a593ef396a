"""Where an anchor that has not been seen yet is more likely."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.objects import catalogue
from ucon.perception.mapping.semantic_map import HALF, SIZE, SemanticMap
from ucon.perception.places.neighbourhood import interest, rooms_of


def wanting(known: SemanticMap, wanted: dict[str, float]) -> np.ndarray:
    """Factors of the worth of unexplored cells if so much of each category is expected there."""
    return interest(known, tuple(wanted), np.array(list(wanted.values())))


def with_things(**at: tuple[float, float]) -> SemanticMap:
    known = SemanticMap()
    known.explored[HALF + 100, HALF + 100] = 1  # the border of the explored area is far from all things
    for name, (x, y) in at.items():
        known.instances[name] = [known.n_tracks]
        known.box[known.n_tracks] = (x - 0.3, y - 0.3, 0.0, x + 0.3, y + 0.3, 0.8)
        known.category.append(name)
    return known


def at(found: np.ndarray, x: float, y: float) -> float:
    return float(found[round(x / 0.25) + HALF, round(y / 0.25) + HALF])


@pytest.mark.parametrize("name", [*catalogue().names[::40], "no_such_thing"])
def test_rooms_add_up(name: str) -> None:
    assert rooms_of(name).sum() == pytest.approx(1.0)


def test_a_fridge_is_looked_for_by_the_stove() -> None:
    found = wanting(with_things(stove=(0.0, 0.0), toilet=(8.0, 0.0)), {"fridge": 0.5})
    assert found.shape == (SIZE, SIZE)
    assert at(found, 1.0, 0.5) > 1.5
    assert at(found, 7.0, 0.5) < 0.7
    assert at(found, 0.0, 20.0) == pytest.approx(1.0, abs=0.01), "far from everything nothing is known"


def test_whoever_looks_for_the_bathtub_goes_the_other_way() -> None:
    known = with_things(stove=(0.0, 0.0), toilet=(8.0, 0.0))
    fridge, bathtub = wanting(known, {"fridge": 1.0}), wanting(known, {"bathtub": 1.0})
    assert at(fridge, 1.0, 0.0) > at(fridge, 7.0, 0.0)
    assert at(bathtub, 1.0, 0.0) < at(bathtub, 7.0, 0.0)


def test_nothing_wanted_changes_nothing() -> None:
    assert (wanting(with_things(stove=(0.0, 0.0)), {}) == 1.0).all()


@pytest.mark.parametrize("name", ["banana", "stairs"])
def test_what_is_no_furniture_or_has_no_room_says_nothing(name: str) -> None:
    found = wanting(with_things(**{name: (0.0, 0.0)}), {"fridge": 1.0})
    assert (found == 1.0).all()


def test_the_border_of_the_unexplored_is_worth_what_it_was() -> None:
    known = with_things(stove=(0.0, 0.0), toilet=(8.0, 0.0))
    known.explored[:] = 0
    known.explored[HALF - 4 : HALF + 40, HALF - 4 : HALF + 5] = 1
    found = wanting(known, {"fridge": 1.0})
    rim = np.zeros((SIZE, SIZE), bool)
    rim[HALF - 6 : HALF + 42, HALF - 6 : HALF + 7] = True
    rim &= known.explored == 0
    assert found[rim].mean() == pytest.approx(1.0, abs=0.01)
