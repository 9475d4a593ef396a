"""The tracker's kernels on small depth images made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.perception.detectors.boxes import Boxes
from ucon.perception.mapping.map_kernels import FAR_M
from ucon.perception.tracking import association_kernels, plane_kernels, segment_kernels
from ucon.perception.tracking.tracker import _painted

ALL = np.zeros((0, 0), bool)
#: At the origin, 1 m above the floor, looking along x, level, with a focal length of 8 pixels.
CAMERA = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 8.0])


def main_depth(
    depth: np.ndarray, box: tuple[int, int, int, int], mask: np.ndarray = ALL, behind: np.ndarray | None = None
) -> float:
    plane = np.zeros(depth.shape, np.int32) if behind is None else behind.astype(np.int32)
    patches = np.array([False, True])
    return float(segment_kernels.main_depth(depth.astype(np.float32), np.array(box, np.int32), mask, plane, patches))


def near(metres: float) -> float:
    return pytest.approx(metres, rel=0.05)


def test_the_inner_half_of_a_box_says_how_far_it_is() -> None:
    depth = np.full((8, 8), 2.0)
    depth[2:5, 2:5] = 1.0  # nine of the inner half's sixteen pixels
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


def test_what_goes_on_beyond_the_box_is_left_out() -> None:
    depth, behind = np.full((8, 8), 2.0), np.ones((8, 8), bool)
    depth[3, 3:5], behind[3, 3:5] = 1.0, False
    assert main_depth(depth, (0, 0, 8, 8)) == near(2.0)
    assert main_depth(depth, (0, 0, 8, 8), behind=behind) == near(1.0)


def scene() -> tuple[np.ndarray, np.ndarray]:
    """Depth of a box 0.5 m wide and high, 2 m away on the floor, with a wall at 4 m; and where the box is."""
    v, u = np.mgrid[:64, :64]
    up, right = (31.5 - v) / 32, (u - 31.5) / 32
    floor = np.where(up < 0, -1.0 / np.minimum(up, -1e-9), 99.0)
    depth = np.minimum(floor, 4.0)
    top = np.where(up < 0, -0.5 / np.minimum(up, -1e-9), 99.0)
    front = (np.abs(right * 2.0) < 0.25) & (up * 2.0 < -0.5) & (up * 2.0 > -1.0)
    above = (top > 2.0) & (top < 2.5) & (np.abs(right * top) < 0.25)
    depth = np.where(above, top, np.where(front, 2.0, depth))
    return depth.astype(np.float32), (front & (up * 2.0 > -0.94)) | above  # lower points count as floor


def test_planes_are_patches_and_what_stands_on_them_is_another() -> None:
    depth, thing = scene()
    plane = np.empty(depth.shape, np.int32)
    n = plane_kernels.planes(depth, plane)
    assert plane.min() == 0
    assert plane.max() == n - 1
    wall, floor = plane[0, 0], plane[-1, 0]
    assert wall != floor
    assert (plane[depth == 4.0] == wall).mean() > 0.97
    assert (plane[(depth < 3.5) & ~thing] == floor).mean() > 0.97
    assert not np.isin(plane[thing], (wall, floor)).any()


@pytest.mark.parametrize("off", [-2, 0, 2])
def test_a_thing_in_a_box_is_not_the_floor_and_wall_around_it(off: int) -> None:
    """Also if the box is too large or too small by two pixels of 16."""
    depth, thing = scene()
    v, u = np.nonzero(thing)
    box = np.array([[u.min() - off, v.min() - off, u.max() + 1 + off, v.max() + 1 + off]], np.int32)
    owner, extent, count = segmented(depth, box)
    inside = np.zeros_like(thing)
    inside[box[0, 1] : box[0, 3], box[0, 0] : box[0, 2]] = True
    assert (owner[thing & inside] == 0).mean() > 0.9
    assert (owner[~thing] == 0).sum() <= 0.05 * thing.sum()
    assert count[0] == (owner == 0).sum()
    assert extent[0, 3] - extent[0, 0] < 0.55
    assert extent[0, 4] - extent[0, 1] < 0.55


def test_a_thing_flush_with_its_neighbours_is_what_the_box_says() -> None:
    depth = np.full((64, 64), 2.0, np.float32)  # the flush fronts of a row of cupboards
    owner, extent, _ = segmented(depth, np.array([[20, 20, 40, 40]], np.int32))
    assert (owner == 0).sum() == 400
    assert extent[0, 4] - extent[0, 1] == pytest.approx(19 / 32 * 2)


def test_what_a_smaller_box_covers_wholly_is_taken_back() -> None:
    depth, thing = scene()
    v, u = np.nonzero(thing)
    box = np.array([u.min(), v.min(), u.max() + 1, v.max() + 1], np.int32)
    owner, _, count = segmented(depth, np.stack([box, box]))
    assert count.min() > 0
    assert (owner[thing] == 0).mean() > 0.9


def segmented(depth: np.ndarray, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n, focal = len(boxes), np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.5 * depth.shape[1]])
    owner, extent = np.full(depth.shape, -1, np.int16), np.tile([np.inf] * 3 + [-np.inf] * 3, (n, 1))
    count, masks = np.zeros(n, np.int32), np.zeros((0, 0, 0), bool)
    segment_kernels.segment(depth, boxes, masks, np.full(n, 2.0), focal, owner, extent, count)
    return owner, extent, count


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
    assert segment_kernels._mean_height(depth, box, 2.0, CAMERA) == pytest.approx(1.0 + 2.0 * 3.0 / 8.0)
    assert segment_kernels._mean_height(depth, box, 1.0, CAMERA) == pytest.approx(1.0 + 1.0 * 3.0 / 8.0)
    assert segment_kernels._mean_height(depth, box, 5.0, CAMERA) == 0.0


def test_a_thing_is_as_large_as_its_points() -> None:
    depth = np.full((8, 8), 4.0, np.float32)
    depth[1:3, 2:6] = 1.0
    owner = np.full((8, 8), -1, np.int16)
    extent, count = np.tile([np.inf] * 3 + [-np.inf] * 3, (1, 1)), np.zeros(1, np.int32)
    boxes, masks = np.array([[2, 1, 6, 3]], np.int32), np.zeros((0, 0, 0), bool)
    segment_kernels.segment(depth, boxes, masks, np.ones(1), CAMERA, owner, extent, count)
    assert count[0] == (owner == 0).sum() == 8
    assert extent[0] == pytest.approx([1.0, -1.5 / 8, 1 + 1.5 / 8, 1.0, 1.5 / 8, 1 + 2.5 / 8])


def test_boxes_have_a_pixel_at_least_and_lie_within_the_frame() -> None:
    xyxy = np.array([[7.9, 3.0, 8.4, 3.1], [-5.0, -5.0, 99.0, 99.0], [9.0, 9.0, 12.0, 12.0]], np.float32)
    boxes, pixels = _painted(Boxes(["a", "b", "c"], np.ones(3, np.float32), xyxy), (8, 8))
    assert boxes.label == ["b", "c", "a"], "the largest first"
    assert pixels.tolist() == [[0, 0, 8, 8], [7, 7, 8, 8], [7, 3, 8, 4]]


def test_what_is_too_large_may_still_be_itself() -> None:
    """Something too large to be a mug but wrongly named so, seen again a little farther on."""
    old = np.array([1.0, 0.0, 0.0, 2.0, 1.5, 1.0])
    assert association_kernels._misfit(old, old + 0.05, 0.3, 0.3) == pytest.approx(0.1 * 0.05 * np.sqrt(3))
    assert association_kernels._misfit(old, old + 0.5, 0.3, 0.3) == np.inf


def test_a_track_takes_the_box_that_fits_it_best() -> None:
    cube = np.array([0.0, 0.0, 0.0, 0.2, 0.2, 0.2])
    boxes = np.stack([cube, cube + 1.0, cube + 0.1])
    extent = np.stack([cube + 0.02, cube + 1.01, cube + 0.11, cube + 5.0, cube])
    track, label = np.empty(5, np.int16), np.array([7, 7, 7, 7, 8], np.int32)
    before, names = boxes.copy(), np.full((3, 2), -1, np.int32)
    names[:, 0] = 7
    association_kernels.associate(extent, np.ones(5, np.int32), label, np.full(5, 0.6), boxes, names, 0.3, track)
    assert track.tolist() == [0, 1, 2, -1, -1], "far away, and after the box of the track's own name"
    assert boxes[1] == pytest.approx([*before[1, :3], *extent[1, 3:]])
    association_kernels.associate(extent, np.zeros(5, np.int32), label, np.full(5, 0.6), boxes, names, 0.3, track)
    assert (track == -1).all(), "boxes without pixels"


def test_a_box_of_another_name_joins_the_track_that_it_covers() -> None:
    cube = np.array([0.0, 0.0, 0.0, 0.2, 0.2, 0.2])
    boxes, names = np.stack([cube, cube + 1.0]), np.array([[7, -1], [7, -1]], np.int32)
    extent = np.stack([cube + 0.03, cube + 1.15, np.array([1.0, 1.0, 1.0, 1.05, 1.05, 1.05])])
    track, label, count = np.empty(3, np.int16), np.array([8, 8, 9], np.int32), np.ones(3, np.int32)
    association_kernels.associate(extent, count, label, np.full(3, 0.6), boxes, names, 0.3, track)
    assert track.tolist() == [0, -1, -1], "not one that it hardly touches, nor a much larger one"
    assert names[0].tolist() == [7, 8]
    association_kernels.associate(extent[:1], count[:1], label[:1] + 2, np.full(1, 0.6), boxes, names, 0.3, track[:1])
    assert track[0] == 0, "a third name"
    assert names[0].tolist() == [7, 8], "is not remembered where there is no room"


def test_shared_pixels_are_counted() -> None:
    image = np.array([[4, 4, 5], [-1, 2, 5]], np.int16)
    instance = np.array([[0, -1, 1], [1, 1, 1]], np.int16)
    pixels = np.zeros((2, 3), np.int32)
    association_kernels.overlaps(image, instance, np.array([-1, -1, -1, -1, 0, 1, -1], np.int32), pixels)
    assert pixels.tolist() == [[1, 1, 0], [0, 0, 2]]
