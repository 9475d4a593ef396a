"""The tracker's kernels on small depth images made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.perception.detectors import tracker_kernels as kernels
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.tracker import Tracker, _painted
from ucon.perception.mapping.map_kernels import FAR_M

ALL = np.zeros((0, 0), bool)
#: At the origin, 1 m above the floor, looking along x, level, with a focal length of 8 pixels.
CAMERA = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 8.0])


def main_depth(depth: np.ndarray, box: tuple[int, int, int, int], mask: np.ndarray = ALL) -> float:
    return float(kernels.main_depth(depth.astype(np.float32), np.array(box, np.int32), mask))


def near(metres: float) -> float:
    return pytest.approx(metres, rel=0.05)


def test_the_inner_half_of_a_box_says_how_far_it_is() -> None:
    depth = np.full((8, 8), 2.0)
    depth[2:5, 2:5] = 1.0  # nine of its sixteen pixels; with one row more it would be nine of twenty
    assert main_depth(depth, (0, 0, 8, 8)) == near(1.0)
    depth[4, 2:5] = 2.0
    assert main_depth(depth, (0, 0, 8, 8)) == near(2.0)


def test_where_that_shows_nothing_the_whole_box_does() -> None:
    depth = np.zeros((8, 8))
    depth[2:6, 2:6] = FAR_M
    depth[0, :3] = 3.0
    assert main_depth(depth, (0, 0, 8, 8)) == near(3.0)
    depth[3, 3] = 1.0
    assert main_depth(depth, (0, 0, 8, 8)) == near(1.0)
    assert main_depth(np.zeros((8, 8)), (0, 0, 8, 8)) == 0.0


def test_a_mask_chooses_its_pixels() -> None:
    depth, mask = np.full((8, 8), 2.0), np.zeros((8, 8), bool)
    depth[3, 3], mask[3, 3] = 1.0, True
    assert main_depth(depth, (0, 0, 8, 8), mask) == near(1.0)
    depth[3, 3] = 0.0
    assert main_depth(depth, (0, 0, 8, 8), mask) == 0.0


def test_heights_are_those_of_the_points_at_its_depth() -> None:
    depth = np.full((8, 8), 2.0, np.float32)
    depth[:, 5], depth[1, :3] = 1.0, 9.0
    box = np.array([3, 0, 6, 2], np.int32)  # up = 3.5 / 8 and 2.5 / 8
    assert kernels._mean_height(depth, box, 2.0, CAMERA) == pytest.approx(1.0 + 2.0 * 3.0 / 8.0)
    assert kernels._mean_height(depth, box, 1.0, CAMERA) == pytest.approx(1.0 + 1.0 * 3.0 / 8.0)
    assert kernels._mean_height(depth, box, 5.0, CAMERA) == 0.0


def test_a_thing_is_as_large_as_its_points() -> None:
    depth = np.full((8, 8), 4.0, np.float32)
    depth[1:3, 2:6] = 1.0
    owner = np.full((8, 8), -1, np.int16)
    extent, count = np.tile([np.inf] * 3 + [-np.inf] * 3, (1, 1)), np.zeros(1, np.int32)
    boxes, masks = np.array([[2, 1, 6, 3]], np.int32), np.zeros((0, 0, 0), bool)
    kernels.segment(depth, boxes, masks, CAMERA, owner, extent, count)
    assert count[0] == (owner == 0).sum() == 8
    assert extent[0] == pytest.approx([1.0, -1.5 / 8, 1 + 1.5 / 8, 1.0, 1.5 / 8, 1 + 2.5 / 8])


def test_boxes_have_a_pixel_at_least_and_lie_within_the_frame() -> None:
    xyxy = np.array([[7.9, 3.0, 8.4, 3.1], [-5.0, -5.0, 99.0, 99.0], [9.0, 9.0, 12.0, 12.0]], np.float32)
    boxes, pixels = _painted(Boxes(["a", "b", "c"], np.ones(3, np.float32), xyxy), (8, 8))
    assert boxes.label == ["b", "c", "a"], "the largest first"
    assert pixels.tolist() == [[0, 0, 8, 8], [7, 7, 8, 8], [7, 3, 8, 4]]


def test_what_is_too_large_may_still_be_itself() -> None:
    """A mug of two metres, by a wrong name, seen again a little farther on."""
    old = np.array([1.0, 0.0, 0.0, 2.0, 1.5, 1.0])
    cost = Tracker()._cost
    assert cost("mug", old, old + 0.05) == pytest.approx(0.1 * 0.05 * np.sqrt(3))
    assert cost("mug", old, old + 0.5) is None
