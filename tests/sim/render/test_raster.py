"""The rasteriser: culling changes no pixel, images are repeatable, buffers are optional, memory is small."""

from __future__ import annotations

import numpy as np
import pytest

from tests.sim.render.homes import build, camera_poses, frame, house_of, scattered, three_rooms
from ucon.core.errors import ConfigError, SceneError
from ucon.scenes import home_spec
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.render import SKY, SKY_DEPTH_M, VIEW_PX, RasterRenderer
from ucon.sim.render.arena import catalogue_model

NAMED = ("Rs_int", "Beechwood_0_int", "Pomaria_0_garden", "grocery_store_cafe", "procedural:office:3")
IDENTITY = (0.0, 0.0, 0.0, 1.0)


def loaded_pair(house: House, arrangement: Arrangement, builder=catalogue_model, size=(96, 72)):
    pair = [RasterRenderer(*size, builder=builder, cull=cull) for cull in (True, False)]
    for renderer in pair:
        renderer.load(house, arrangement)
    return pair


def assert_same_pictures(pair, poses) -> None:
    for pose in poses:
        for culled, whole in zip(frame(pair[0], *pose), frame(pair[1], *pose), strict=True):
            np.testing.assert_array_equal(culled, whole, err_msg=str(pose))
        np.testing.assert_array_equal(pair[0].visible(*pose), pair[1].visible(*pose), err_msg=str(pose))


@pytest.mark.parametrize("stage", ["closed", "opened"])
def test_culling_changes_no_pixel_in_three_rooms(stage: str) -> None:
    house = house_of(three_rooms())
    pair = loaded_pair(house, scattered(house, 12, ("ball", "jar", "ramp", "block")), build)
    if stage == "opened":
        for renderer in pair:
            renderer.set_open(0, 1.0)
    assert_same_pictures(pair, camera_poses(house, 150, stage))


@pytest.mark.parametrize("name", NAMED)
def test_culling_changes_no_pixel_in_named_homes(name: str) -> None:
    house = house_of(home_spec(name))
    pair = loaded_pair(house, scattered(house, 20, ("apple", "rum_bottle", "notebook", "vase")))
    poses = camera_poses(house, 40, "named")
    assert_same_pictures(pair, poses[:20])
    for instance in range(house.n_items):
        for renderer in pair:
            renderer.set_open(instance, 1.0)
    assert_same_pictures(pair, poses[20:])


def test_same_view_same_bytes() -> None:
    house = house_of(three_rooms())
    first, second = RasterRenderer(builder=build), RasterRenderer(builder=build)
    for renderer in (first, second):
        renderer.load(house)
    poses = camera_poses(house, 10, "repeat")
    pictures = [[part.tobytes() for part in frame(first, *pose)] for pose in poses]
    for pose, expected in reversed(list(zip(poses, pictures, strict=True))):
        assert [part.tobytes() for part in frame(second, *pose)] == expected


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (33, 64), (224, 224), (320, 180)])
def test_any_size_and_any_subset_of_buffers(size: tuple[int, int]) -> None:
    house = house_of(three_rooms())
    renderer = RasterRenderer(*size, fov_deg=75.0, builder=build)
    renderer.load(house)
    pose = (2.0, 2.0, 1.25, 1, -30)
    whole = frame(renderer, *pose)
    for kept in range(3):
        parts = [np.full_like(part, 3) for part in whole]
        renderer.render(*pose, **{("rgb", "depth", "instance")[kept]: parts[kept]})
        np.testing.assert_array_equal(parts[kept], whole[kept])
    counts = np.full(renderer.n_instances, -1, np.int32)
    renderer.render(*pose, counts=counts)
    np.testing.assert_array_equal(counts, renderer.visible(*pose))
    assert counts.sum() <= VIEW_PX * VIEW_PX


def test_counts_are_those_of_the_128_pixel_view() -> None:
    house = house_of(three_rooms())
    view, other = RasterRenderer(builder=build), RasterRenderer(64, 48, 60.0, builder=build)
    for renderer in (view, other):
        renderer.load(house)
        renderer.set_open(1, 0.5)
    for pose in camera_poses(house, 12, "counts"):
        instance = frame(view, *pose)[2]
        expected = np.bincount(instance[instance >= 0], minlength=view.n_instances)
        np.testing.assert_array_equal(view.visible(*pose), expected)
        np.testing.assert_array_equal(other.visible(*pose), expected)


def test_depth_is_measured_along_the_axis() -> None:
    house = house_of(three_rooms())
    renderer = RasterRenderer(64, 64, builder=build)
    renderer.load(house)
    _, depth, instance = frame(renderer, 2.0, 4.4, 1.25, 1, 0)
    wall = instance == house.n_items + 1
    np.testing.assert_allclose(depth[wall], 5.0 - 0.05 - 4.4, atol=1e-4)


def test_sky_outdoors_and_no_ceiling_from_above() -> None:
    house = house_of(three_rooms())
    renderer = RasterRenderer(builder=build)
    renderer.load(house)
    _, depth, instance = frame(renderer, 9.0, 3.0, 1.25, 0, 30)
    assert (instance == SKY).any()
    assert (depth[instance == SKY] == SKY_DEPTH_M).all()
    seen_from_above = renderer.visible(2.0, 2.0, 6.0, 0, -60)
    ceilings = house.n_items + 2 + 3 * np.arange(len(house.spec.rooms))
    assert seen_from_above[ceilings].sum() == 0
    assert seen_from_above[house.n_items] > 0


def test_drawer_takes_its_content_along_and_hides_it_when_closed() -> None:
    house = house_of(three_rooms())
    inside = PlacedObject("ball", (0.35, 2.5, 0.08), IDENTITY, 0, "inside", 0, holder=0, compartment=0)
    renderer = RasterRenderer(builder=build)
    renderer.load(house, Arrangement(objects=(inside,)))
    ball = house.n_instances
    pose = (1.5, 2.5, 1.25, 2, -30)
    assert renderer.visible(*pose)[ball] == 0
    before = renderer.arena.tables.group_boxes[ball].copy()
    renderer.set_open(0, 1.0)
    moved = renderer.arena.tables.group_boxes[ball] - before
    np.testing.assert_allclose(moved, [0.4, 0, 0, 0.4, 0, 0], atol=1e-5)
    assert renderer.visible(*pose)[ball] > 4
    renderer.set_open(0, 0.0)
    np.testing.assert_array_equal(renderer.arena.tables.group_boxes[ball], before)
    assert renderer.visible(*pose)[ball] == 0


def test_removed_instances_are_gone() -> None:
    house = house_of(three_rooms())
    renderer = RasterRenderer(builder=build)
    renderer.load(house, Arrangement(removed=(2,)))
    assert all(renderer.visible(*pose)[2] == 0 for pose in camera_poses(house, 20, "removed"))
    renderer.load(house)
    assert any(renderer.visible(*pose)[2] > 0 for pose in camera_poses(house, 20, "removed"))


@pytest.mark.parametrize("name", NAMED)
def test_memory_of_a_home(name: str) -> None:
    renderer = RasterRenderer()
    renderer.load(house_of(home_spec(name)))
    assert renderer.arena.nbytes < 2_000_000


def test_every_room_is_closed() -> None:
    """Indoors, every pixel shows something other than sky."""
    house = house_of(home_spec("Rs_int"))
    renderer = RasterRenderer(64, 64)
    renderer.load(house)
    for pose in camera_poses(house, 40, "closed"):
        assert (frame(renderer, *pose)[2] != SKY).all(), pose


def test_textures_change_colours_only() -> None:
    house = house_of(three_rooms())
    plain, rich = RasterRenderer(builder=build, textured=False), RasterRenderer(builder=build)
    for renderer in (plain, rich):
        renderer.load(house)
    flat, shaded = frame(plain, 2.0, 2.0, 1.25, 0, -30), frame(rich, 2.0, 2.0, 1.25, 0, -30)
    np.testing.assert_array_equal(flat[1], shaded[1])
    np.testing.assert_array_equal(flat[2], shaded[2])
    floor = flat[2] == house.n_items
    assert len(np.unique(flat[0][floor], axis=0)) == 1
    assert len(np.unique(shaded[0][floor], axis=0)) > 20


def test_bad_use_is_refused() -> None:
    with pytest.raises(ConfigError, match="4096"):
        RasterRenderer(0, 128)
    with pytest.raises(ConfigError, match="field of view"):
        RasterRenderer(fov_deg=180.0)
    renderer = RasterRenderer(16, 16, builder=build)
    with pytest.raises(SceneError, match="load"):
        renderer.visible(0.0, 0.0, 1.25, 0, 0)
    renderer.load(house_of(three_rooms()))
    with pytest.raises(ConfigError, match=r"depth buffer .* expected"):
        renderer.render(1.0, 1.0, 1.25, 0, 0, depth=np.empty((16, 16)))
    with pytest.raises(ConfigError, match="contiguous"):
        renderer.render(1.0, 1.0, 1.25, 0, 0, rgb=np.empty((16, 32, 3), np.uint8)[:, ::2])
