"""The small image that policies over the seven actions see."""

from __future__ import annotations

import numpy as np
import pytest

from models.nets.vision.eye import FARTHEST_M, small_image
from ucon.core.rng import stream


@pytest.mark.parametrize(("pixels", "size"), [(128, 64), (128, 32), (96, 32), (32, 32)])
def test_means_of_colours_and_least_of_depths(pixels: int, size: int) -> None:
    draw = stream(0, "image", pixels, size)
    rgb = draw.integers(0, 256, (pixels, pixels, 3), dtype=np.uint8)
    depth = draw.uniform(-1.0, 1.5 * FARTHEST_M, (pixels, pixels)).astype(np.float32)
    depth[draw.random(depth.shape) < 0.2] = np.inf
    blocks = (size, pixels // size, size, pixels // size)
    image = small_image(rgb, depth, size)
    np.testing.assert_array_equal(image[:3], np.moveaxis(rgb.reshape(*blocks, 3).mean((1, 3)).astype(np.uint8), -1, 0))
    near = np.clip(depth.reshape(blocks).min((1, 3)), 0.0, FARTHEST_M)
    np.testing.assert_array_equal(image[3], (near * (255.0 / FARTHEST_M)).astype(np.uint8))
