"""Boxes of furniture from many looks, and tracks of the same thing, with a detector that errs."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.objects.catalogue import catalogue
from ucon.perception.errors.model import read_errors
from ucon.perception.hypotheses.hypotheses import name_rows
from ucon.perception.mapping.detections import Detections
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.mapping.settling import LookBoxes, United

PX, FOCAL_PX = 128, 64.0
FRIDGE, SOFA = name_rows()["fridge"], name_rows()["sofa"]
SIZE = np.array(catalogue()["fridge"].size)
#: The centre of a fridge, metres.
MIDDLE = np.array([2.0, 0.0, 1.0])


def camera(yaw: float, away_m: float) -> np.ndarray:
    """A camera at a distance from the centre, at the same height, looking at it."""
    x, y = MIDDLE[:2] - away_m * np.array([np.cos(yaw), np.sin(yaw)])
    return np.array([x, y, MIDDLE[2], np.cos(yaw), np.sin(yaw), 1.0, 0.0, FOCAL_PX])


def frame(wide_m: float, high_m: float, away_m: float, track: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A plate of a given size, perpendicular to the view: depth and track of each pixel."""
    depth, image = np.full((PX, PX), 9.0, np.float32), np.full((PX, PX), -1, np.int16)
    u, v = round(0.5 * wide_m / away_m * FOCAL_PX), round(0.5 * high_m / away_m * FOCAL_PX)
    rows, columns = slice(PX // 2 - v, PX // 2 + v), slice(PX // 2 - u, PX // 2 + u)
    depth[rows, columns], image[rows, columns] = away_m, track
    return depth, image


def seen(
    looks: LookBoxes, yaw: float, wide_m: float, *, away_m: float = 2.5, name: int = FRIDGE, opened: bool = False
) -> None:
    depth, image = frame(wide_m, SIZE[2], away_m)
    looks.look(depth, image, camera(yaw, away_m), np.array([name], np.int32), np.array([opened]))


def settled(looks: LookBoxes, name: int = FRIDGE) -> np.ndarray:
    box = np.array([[9.0, 9.0, 9.0, 9.0, 9.0, 9.0]])
    looks.settle(np.array([name], np.int32), box)
    return box[0]


@pytest.fixture
def looks() -> LookBoxes:
    return LookBoxes(read_errors("noisy"))


def test_one_look_that_took_in_what_stands_beside_is_left_out(looks: LookBoxes) -> None:
    for yaw in np.pi * np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.25]):
        seen(looks, yaw, 0.7)
    good = settled(looks)
    seen(looks, 1.5 * np.pi, 4.0)
    assert settled(looks) == pytest.approx(good, abs=0.12)
    assert np.linalg.norm(good[3:] - good[:3]) < 1.2 * np.linalg.norm(SIZE)


def test_a_thing_as_large_as_its_kind_keeps_all_that_was_seen(looks: LookBoxes) -> None:
    for yaw in (0.0, 0.5 * np.pi):
        seen(looks, yaw, 0.5)
    box = settled(looks)
    assert box[3:5] - box[:2] == pytest.approx([0.5, 0.5], abs=0.1)


def test_of_one_side_and_distance_the_fullest_look_counts(looks: LookBoxes) -> None:
    seen(looks, 0.0, 0.7)
    box = settled(looks)
    seen(looks, 0.02, 0.3)
    assert (settled(looks) == box).all()


def test_looks_that_call_it_something_else_count_only_where_there_are_no_others(looks: LookBoxes) -> None:
    seen(looks, 0.0, 0.7, name=SOFA)
    assert settled(looks)[4] - settled(looks)[1] == pytest.approx(0.7, abs=0.1)
    seen(looks, np.pi, 0.4)
    assert settled(looks)[4] - settled(looks)[1] == pytest.approx(0.4, abs=0.1)


def test_doors_that_swing_are_not_looked_at(looks: LookBoxes) -> None:
    seen(looks, 0.0, 0.7, opened=True)
    assert (settled(looks) == 9.0).all()


def test_what_is_left_out_or_forgotten_keeps_its_box(looks: LookBoxes) -> None:
    seen(looks, 0.0, 0.7)
    assert (settled(looks, name=-1) == 9.0).all()
    looks.forget([0, 70])
    assert (settled(looks) == 9.0).all()


def test_many_tracks_have_room(looks: LookBoxes) -> None:
    depth, image = frame(0.7, 1.5, 2.5, track=200)
    named = np.full(201, -1, np.int32)
    named[200] = FRIDGE
    looks.look(depth, image, camera(0.0, 2.5), named, np.zeros(201, bool))
    box = np.full((300, 6), 9.0)
    looks.settle(np.append(named, np.full(99, FRIDGE, np.int32)), box)
    assert (box[200] != 9.0).any()
    assert (np.delete(box, 200, axis=0) == 9.0).all()


CUPBOARD = np.array([0.0, 0.0, 0.0, 1.0, 0.5, 1.0])
BESIDE = CUPBOARD + [1.0, 0.0, 0.0] * 2


def united(boxes: list[np.ndarray], names: list[int], found: list[float]) -> tuple[United, list[int]]:
    one = United()
    return one, one.unite(np.array(boxes), np.array(names, np.int32), np.array(found))


def test_of_one_thing_the_track_stays_that_was_found_most_often() -> None:
    one, gone = united([CUPBOARD, CUPBOARD + 0.1, BESIDE], [FRIDGE] * 3, [2.0, 5.0, 1.0])
    assert gone == [0]
    assert [one.of(track) for track in range(4)] == [1, 1, 2, 3]


@pytest.mark.parametrize(("off_m", "gone"), [(0.02, [1]), (0.6, [])])
def test_things_of_two_names_are_one_only_where_their_boxes_nearly_agree(off_m: float, gone: list[int]) -> None:
    """Two boxes 0.02 m apart are one thing whatever their names; 0.6 m apart only if they have the same name."""
    boxes = [CUPBOARD, CUPBOARD + np.array([off_m, 0, 0, off_m, 0, 0])]
    assert united(boxes, [FRIDGE, SOFA], [2.0, 1.0])[1] == gone
    assert united(boxes, [FRIDGE, FRIDGE], [2.0, 1.0])[1] == [1]


def test_what_is_left_out_is_united_with_nothing() -> None:
    assert united([CUPBOARD, CUPBOARD], [FRIDGE, -1], [1.0, 2.0])[1] == []


def test_uniting_goes_on_over_searches() -> None:
    one, _ = united([CUPBOARD, CUPBOARD], [FRIDGE] * 2, [1.0, 2.0])
    names, found = np.array([-1, FRIDGE, FRIDGE], np.int32), np.array([0.0, 1.0, 3.0])
    one.unite(np.array([BESIDE, CUPBOARD, CUPBOARD]), names, found)
    assert [one.of(track) for track in range(3)] == [2, 2, 2]


def test_a_frame_has_one_track_of_each_thing() -> None:
    one, _ = united([CUPBOARD, CUPBOARD], [FRIDGE] * 2, [1.0, 2.0])
    image = np.array([[0, 1, 1], [-1, 5, 0]], np.int16)
    found = Detections(
        np.array([0, 1, 5], np.int32), ["crib", "fridge", "mug"], np.array([2, 7, 1], np.int32), image,
        np.array([0.3, 0.6, 0.9], np.float32),
    )  # fmt: skip
    seen = one.detections(found)
    assert (seen.track.tolist(), list(seen.category), seen.pixels.tolist()) == ([1, 5], ["fridge", "mug"], [7, 1])
    assert seen.score is not None
    assert seen.score.tolist() == pytest.approx([0.6, 0.9])
    assert seen.image.tolist() == [[1, 1, 1], [-1, 5, 1]]
    assert United().detections(found) is found


def test_a_map_that_is_kept_forgets_what_was_looked_for_in_vain() -> None:
    """Of two tracks of one sofa, a fridge that is never found again, and a table, one sofa and the table are kept."""
    known = SemanticMap(errors=read_errors("noisy"), target="mug", kept=True)
    known.category = ["sofa", "sofa", "fridge", "breakfast_table"]
    known.instances = {"sofa": [0, 1], "fridge": [2], "breakfast_table": [3]}
    known.box[:4] = [CUPBOARD, CUPBOARD + 0.1, BESIDE, BESIDE + 5.0]
    beliefs = known.hypotheses
    assert beliefs is not None
    beliefs._reserve(4)
    beliefs._found[:4], beliefs._absent[:4] = [2, 3, 1, 1], [0.0, 0.0, -4.0, 0.0]
    beliefs.looks = {track: [(0, 0.5, 1.0)] for track in range(4)}
    known.search_again("mug")
    assert known.instances == {"sofa": [1], "breakfast_table": [3]}
    assert [known.seen(track) for track in range(4)] == [False, True, False, True]
    assert sorted(beliefs.looks) == [1, 3]
    assert known.united.of(0) == 1


def test_maps_that_are_not_kept_and_exact_detectors_do_without() -> None:
    assert SemanticMap(errors=read_errors("noisy"), target="mug").looks is None
    assert SemanticMap(target="mug", kept=True).looks is None
