"""The stereo camera: range, errors that grow with the square of the distance, and shadows."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.sim.robot.stereo import ERROR_AT_1_M, stereo

FOCAL_PX = 64.0 / np.tan(np.radians(30.0))


def readings(depth: np.ndarray, key: int = 7) -> np.ndarray:
    image = depth.astype(np.float32)
    stereo(image, key, FOCAL_PX)
    return image


@pytest.mark.parametrize("metres", [0.5, 1.0, 2.0, 4.0])
def test_errors_grow_with_the_square_of_the_distance(metres: float) -> None:
    found = readings(np.full((128, 128), metres))
    assert (found > 0).all()
    assert found.mean() == pytest.approx(metres, abs=3e-4 * metres**2 + 1e-4)
    assert found.std() == pytest.approx(ERROR_AT_1_M * metres**2, rel=0.05)
    whole = found * 1000
    assert np.abs(whole - np.round(whole)).max() < 1e-2


def test_neighbours_err_independently_and_keys_differ() -> None:
    depth = np.full((128, 128), 3.0)
    a, b = readings(depth, 1), readings(depth, 2)
    assert np.array_equal(a, readings(depth, 1))
    flat = (a - 3.0).ravel(), (b - 3.0).ravel()
    assert abs(np.corrcoef(*flat)[0, 1]) < 0.03
    assert abs(np.corrcoef(flat[0][1:], flat[0][:-1])[0, 1]) < 0.03


def test_nothing_is_read_too_near_or_too_far() -> None:
    for metres in (0.0, 0.1, 0.29, 6.01, 100.0):
        assert (readings(np.full((4, 8), metres)) == 0).all()


def test_a_thing_in_front_casts_a_shadow_to_its_left() -> None:
    near, far = 1.0, 3.0
    depth = np.full((16, 128), far)
    depth[:, 60:80] = near
    blind = readings(depth) == 0
    width = round(FOCAL_PX * 0.05 * (1 / near - 1 / far))
    columns = np.flatnonzero(blind.any(0))
    assert width >= 3
    assert columns.max() == 59
    assert abs(len(columns) - width) <= 1
    assert (np.diff(columns) == 1).all()
