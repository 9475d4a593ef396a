"""PyBullet's renderer, drawing our polygons, must show the same as the rasteriser."""

from __future__ import annotations

import numpy as np
import pytest

from tests.sim.render.homes import build, camera_poses, frame, house_of, scattered, three_rooms
from ucon.scenes import home_spec
from ucon.sim.render import RasterRenderer
from ucon.sim.render.arena import catalogue_model

pytest.importorskip("pybullet", reason="PyBullet has no wheel for this Python")

from ucon.sim.render.tiny import TINY_SAMPLE, TinyRenderer


@pytest.mark.parametrize("name", ["three_rooms", "Rs_int", "Merom_0_int"])
def test_agreement_with_tiny_renderer(name: str) -> None:
    house = house_of(three_rooms() if name == "three_rooms" else home_spec(name))
    builder = build if name == "three_rooms" else catalogue_model
    categories = ("ball", "jar", "ramp") if name == "three_rooms" else ("apple", "rum_bottle", "notebook")
    ours = RasterRenderer(builder=builder, sample=TINY_SAMPLE)
    tiny = TinyRenderer(builder=builder, oracle=True)
    try:
        for renderer in (ours, tiny):
            renderer.load(house, scattered(house, 10, categories))
        agreement, difference = [], []
        for number, pose in enumerate(camera_poses(house, 16, "tiny")):
            if number == 8:
                for instance in range(house.n_items):
                    ours.set_open(instance, 1.0)
                    tiny.set_open(instance, 1.0)
            (_, depth, instance), (_, depth_tiny, instance_tiny) = frame(ours, *pose), frame(tiny, *pose)
            same = instance == instance_tiny
            agreement.append(same.mean())
            difference.append(np.median(np.abs(depth - depth_tiny)[same]))
    finally:
        tiny.close()
    assert np.mean(agreement) >= 0.995
    assert np.max(difference) < 0.002


def test_use_as_a_fallback_is_loud() -> None:
    with pytest.warns(RuntimeWarning, match="100 times slower"):
        TinyRenderer(16, 16, builder=build).close()
