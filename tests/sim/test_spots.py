"""Spots: at the foot of the bed, behind the laptop, facing the front."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.core.errors import PlacementError
from ucon.core.rng import stream
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.cache import load_house
from ucon.sim.house import House
from ucon.sim.placement import place, with_object
from ucon.sim.placement.spot import SIDES, Side, Spot
from ucon.sim.placement.surroundings import Surroundings

EMPTY = Arrangement()


@pytest.fixture(scope="module")
def house() -> House:
    return load_house("Rs_int")


def number_of(house: House, category: str) -> int:
    return house.categories.index(category)


def in_frame_of(house: House, anchor: int, placed: PlacedObject, around: Arrangement = EMPTY) -> np.ndarray:
    """Position ahead and left of an anchor's centre in the anchor's frame, metres."""
    scene = Surroundings(house, around)
    box = scene.boxes[anchor]
    away = np.array(placed.position[:2]) - (box[:2] + box[3:5]) / 2
    return scene.standing[anchor].turn[:2, :2].T @ away


def test_sides_of_the_bed(house: House) -> None:
    """The foot is ahead of the head for any seed; left and right are as seen by somebody standing at the foot."""
    bed = number_of(house, "bed")

    def at(side: Side, seed: int) -> np.ndarray:
        return in_frame_of(house, bed, place(house, EMPTY, "paperback_book", "ontop", bed, stream(seed), Spot(side)))

    found = {side: np.array([at(side, seed) for seed in range(4)]) for side in SIDES}
    assert found["front"][:, 0].min() > 0.4
    assert found["front"][:, 0].min() > found["behind"][:, 0].max() + 0.3
    assert found["right"][:, 1].min() > found["left"][:, 1].max() + 0.3


def test_behind_a_laptop_that_faces_the_chair(house: House) -> None:
    """The pen lies on the side of the laptop that its screen hides."""
    table = number_of(house, "breakfast_table")
    for seed in range(3):
        laptop = place(house, EMPTY, "laptop", "ontop", table, stream(seed), Spot("front", facing=True))
        around = with_object(house, EMPTY, laptop)
        number, scene = house.n_instances, Surroundings(house, around)
        assert scene.standing[number].turn[:, 0] @ scene.standing[table].turn[:, 0] > 0.9
        pen = place(house, around, "pen", "nextto", number, stream(seed), Spot("behind"))
        ahead, left = in_frame_of(house, number, pen, around)
        assert ahead < -0.1
        assert abs(left) < 0.2


def test_without_a_spot_nothing_changes(house: House) -> None:
    bed = number_of(house, "bed")
    said = [place(house, EMPTY, "mug", "ontop", bed, stream(3), *spot) for spot in ((), (Spot(),), (Spot(room=7),))]
    assert said[0] == said[1] == said[2]


def test_a_side_that_has_no_room_is_refused(house: House) -> None:
    """The head of the bed is at the wall, so nothing fits next to it there."""
    bed = number_of(house, "bed")
    with pytest.raises(PlacementError, match="no place found for suitcase nextto bed"):
        place(house, EMPTY, "suitcase", "nextto", bed, stream(0), Spot("behind"))
