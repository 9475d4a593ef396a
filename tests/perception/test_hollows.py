"""Which things can be looked into and from where, and how things are oriented."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.objects import catalogue
from ucon.objects.models import build_model
from ucon.perception.mapping.map_kernels import shows
from ucon.perception.places.hollows import ALL_OPEN, fit, open_faces, template
from ucon.perception.places.place_kernels import INSIDE, ONTOP, facing
from ucon.scenes import SCENES, home_spec
from ucon.sim.cache import load_house

FRONT, ABOVE = 2, 32


@pytest.mark.parametrize(
    ("name", "side"),
    [
        ("fridge", FRONT), ("bottom_cabinet", FRONT), ("top_cabinet", FRONT), ("wardrobe", FRONT), ("shelf", FRONT),
        ("microwave", FRONT), ("washer", FRONT), ("nightstand", FRONT), ("backpack", ABOVE), ("hamper", ABOVE),
        ("bucket", ABOVE), ("storage_box", ABOVE), ("cedar_chest", ABOVE), ("recycling_bin", ABOVE), ("bowl", ABOVE),
    ],
)  # fmt: skip
def test_open_sides(name: str, side: int) -> None:
    model = build_model(name)
    assert {open_faces(model, compartment) for compartment in model.compartments} == {side}


@pytest.mark.parametrize("name", catalogue().names)
def test_templates(name: str) -> None:
    shape, model = template(name), build_model(name)
    assert shape.has(INSIDE) == bool(model.compartments)
    for relation in (ONTOP, INSIDE):
        if shape.has(relation):
            assert shape.share[shape.relation == relation].sum() == pytest.approx(1.0)
    assert (shape.faces[shape.relation == ONTOP] == ALL_OPEN).all()
    assert (np.bitwise_count(shape.turned_faces(1)) == np.bitwise_count(shape.faces)).all()


def test_faces_turn_counter_clockwise() -> None:
    shape = template("fridge")
    inside = shape.relation == INSIDE
    assert [int(shape.turned_faces(q)[inside][0]) for q in range(4)] == [2, 8, 1, 4]


@pytest.mark.parametrize("quarters", range(4))
def test_a_template_fits_a_thing_turned(quarters: int) -> None:
    """However a wardrobe is turned, its interior is inside it and can be seen from its front."""
    shape = template("wardrobe")
    deep, wide = shape.size[0], shape.size[1]
    sides = (deep, wide) if quarters % 2 == 0 else (wide, deep)
    box = np.array([2.0, 3.0, 0.0, 2.0 + sides[0], 3.0 + sides[1], shape.size[2]])
    rows, faces = np.zeros((len(shape.share), 12)), np.zeros(len(shape.share), np.uint8)
    fit(shape, box, quarters, 0.05, rows, faces)
    inside = shape.relation == INSIDE
    xyz, hollow = rows[inside, :3], rows[inside, 6:]
    assert (hollow[:, :3] >= box[:3] - 1e-9).all()
    assert (hollow[:, 3:] <= box[3:] + 1e-9).all()
    assert (hollow[:, :3] <= xyz).all()
    assert (xyz <= hollow[:, 3:]).all()
    front = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][quarters], float)
    middle = 0.5 * (box[:2] + box[3:5])
    eye, behind = middle + 1.5 * front, middle - 1.5 * front
    in_front = [shows(*eye, 1.25, *xyz[k], hollow[k], faces[inside][k]) for k in range(len(xyz))]
    at_back = [shows(*behind, 1.25, *xyz[k], hollow[k], faces[inside][k]) for k in range(len(xyz))]
    assert np.mean(in_front) > 0.5
    assert not any(at_back)


def test_a_sight_line_must_enter_by_an_open_side() -> None:
    hollow = np.array([0.0, 0.0, 0.0, 0.5, 0.8, 0.4])
    point = (0.2, 0.4, 0.1)
    assert shows(3.0, 0.4, 1.25, *point, hollow, FRONT)
    assert not shows(0.6, 0.4, 1.25, *point, hollow, FRONT), "too near: the top is in between"
    assert not shows(-3.0, 0.4, 1.25, *point, hollow, FRONT)
    assert shows(0.35, 0.5, 1.25, *point, hollow, ABOVE)
    assert not shows(2.0, 0.4, 1.25, *point, hollow, ABOVE)
    assert shows(-3.0, 0.4, 1.25, *point, hollow, ALL_OPEN)


def opens_in_front(name: str) -> bool:
    shape = template(name)
    return catalogue()[name].openable and shape.has(INSIDE) and set(shape.faces[shape.relation == INSIDE]) == {FRONT}


def test_fronts_are_found_in_homes() -> None:
    """With floor and walls known, the orientation of at least 95 % of things that open at the front is found."""
    right, total = 0, 0
    for name in SCENES:
        house = load_house(name)
        spec = home_spec(name)
        chosen = [k for k, item in enumerate(spec.items) if opens_in_front(item.category)]
        free = house.grid.free.astype(np.uint8)
        nx, ny = free.shape
        half = 128
        floor, blocked = (np.zeros((257, 257), np.uint8) for _ in range(2))
        floor[half : half + nx, half : half + ny] = 1
        blocked[half : half + nx, half : half + ny] = 1 - free
        walls = np.zeros((2, 257, 257), np.uint8)
        room = np.pad(house.grid.room, 1, constant_values=-9)
        walls[0, half - 1 : half + nx, half : half + ny] = room[1:, 1:-1] != room[:-1, 1:-1]
        walls[1, half : half + nx, half - 1 : half + ny] = room[1:-1, 1:] != room[1:-1, :-1]
        origin = np.array(house.grid.origin_xy) + 0.125
        boxes = house.boxes[chosen] - np.array([*origin, 0.0, *origin, 0.0])
        sizes = np.array([template(spec.items[k].category).size for k in chosen])
        turns = np.full(len(chosen), -1, np.int32)
        facing(boxes, sizes, floor, blocked, walls, half, turns)
        truth = np.array([spec.items[k].quarter_turns % 4 for k in chosen])
        right, total = right + int((turns == truth).sum()), total + len(chosen)
    assert total > 100
    assert right >= 0.95 * total, f"{right} of {total}"
