"""Whether something stands at a place, judged by depth alone."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.perception.mapping.body import PAPER_BODY
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View, camera_of
from ucon.perception.places.occupied import IS_EMPTY, STANDS, Occupied, boxes_above
from ucon.perception.places.occupied_kernels import fill

PX = 128
#: The centre of a cup of 0.2 m, 1 m ahead and at the camera's height.
CUP = np.array([[1.0, 0.0, PAPER_BODY.camera_m]])
SIZE = np.full((1, 3), 0.2)


def looking(heading: int = 0) -> SemanticMap:
    known = SemanticMap()
    known.views.append(View(HALF, HALF, heading))
    return known


def frame(metres: float, width: int = PX) -> np.ndarray:
    """A wall 3 m away, and in the middle of the image a square plate, ``width`` pixels wide, at a given distance."""
    depth = np.full((PX, PX), 3.0, np.float32)
    side = slice(PX // 2 - width // 2, PX // 2 + width // 2)
    depth[side, side] = metres
    return depth


def test_what_ends_in_a_box_fills_it_and_what_goes_on_passes() -> None:
    known = looking()
    camera = camera_of(known.view, frame(3.0), known.body)
    filled, passed = np.zeros(1, np.int32), np.zeros(1, np.int32)
    boxes = boxes_above(CUP, SIZE)
    fill(frame(3.0), camera, boxes, filled, passed)
    assert filled[0] == 0
    #: 0.2 m wide and nearly as high, at 0.9 m and with 64 pixels at a metre: about 14 pixels a side.
    assert passed[0] == pytest.approx(14 * 14, rel=0.2)
    whole = int(passed[0])
    fill(frame(0.97), camera, boxes, filled, passed)
    assert (filled[0], passed[0]) == (whole, 0)
    fill(frame(0.5), camera, boxes, filled, passed)
    assert (filled[0], passed[0]) == (0, 0), "what hides a place says nothing of it"


def test_a_place_that_is_not_in_the_picture_has_no_lines() -> None:
    known = looking(heading=2)
    filled, passed = np.ones(1, np.int32), np.ones(1, np.int32)
    fill(frame(3.0), camera_of(known.view, frame(3.0), known.body), boxes_above(CUP, SIZE), filled, passed)
    assert (filled[0], passed[0]) == (0, 0)


def test_something_stands_there_or_nothing_does() -> None:
    places = Occupied(CUP, SIZE, [()])
    assert not places.asked.any()
    assert places.likelihood().tolist() == [1.0]
    places.look(looking(), frame(3.0))
    assert places.asked.all()
    assert places.likelihood().tolist() == [IS_EMPTY]
    places.look(looking(), frame(0.97))
    assert places.stands.all()
    assert places.likelihood().tolist() == [STANDS]
    assert places.now[0] > 0


def test_the_frame_that_shows_most_of_a_place_counts() -> None:
    places = Occupied(CUP, SIZE, [()])
    places.look(looking(), frame(0.97))
    shown = frame(0.5)
    shown[: PX // 2 - 2] = 3.0  # only the upper rows are not hidden, and they are empty
    places.look(looking(), shown)
    assert places.stands.all()
    assert places.now[0] == 0


def test_places_of_unknown_size_are_not_asked_for() -> None:
    places = Occupied(CUP, np.zeros((1, 3)), [()])
    places.look(looking(), frame(0.97))
    assert not places.asked.any()


def test_what_a_thing_stands_on_is_no_part_of_its_place() -> None:
    (box,) = boxes_above(CUP, SIZE)
    assert box[2] == pytest.approx(CUP[0, 2] - 0.1 + 0.015)
    (flat,) = boxes_above(CUP, np.array([[0.2, 0.2, 0.02]]))
    assert CUP[0, 2] - 0.01 < flat[2] < flat[5]


def test_what_is_in_a_container_is_asked_for_once_that_is_open() -> None:
    """The door of a fridge has the same depth as the milk behind it."""
    places = Occupied(CUP, SIZE, [(("inside", "fridge"), ("nextto", "stove"))])
    known = looking()
    known.category.append("fridge")
    known.box[0] = [0.7, -0.4, 0.0, 1.3, 0.4, 1.8]
    places.look(known, frame(0.97))
    assert not places.asked.any()
    assert places.now[0] == 0
    known.opened[0] = True
    places.look(known, frame(0.97))
    assert places.stands.all()


def test_a_shelf_without_doors_is_no_such_container() -> None:
    places = Occupied(CUP, SIZE, [(("inside", "shelf"),)])
    places.look(looking(), frame(0.97))
    assert places.stands.all()
