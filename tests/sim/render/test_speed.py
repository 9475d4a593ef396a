"""A loose bound on the renderer's speed, relative to TinyRenderer in the same process."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.sim.cache import load_house
from ucon.sim.render.bench import bench_renderer


@pytest.mark.parametrize("scene", ["Rs_int", "grocery_store_cafe"])
def test_at_least_30_times_as_fast_as_tiny(scene: str) -> None:
    figures = bench_renderer([load_house(scene)], poses=16, rounds=2)
    assert figures["renderer_ratio_128"] >= 30
    assert figures["renderer_ratio_128_flat"] >= 30
    assert np.isfinite(list(figures.values())).all()
