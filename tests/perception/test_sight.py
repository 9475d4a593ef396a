"""Looks with a detector that errs: they find with some chance, and count once per side and distance."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.perception.errors.model import read_errors
from ucon.perception.hypotheses.hypotheses import limits_m2
from ucon.perception.hypotheses.look_kernels import look_key
from ucon.perception.places import chance_kernels as kernels
from ucon.perception.places.sight import PASSES, Sight
from ucon.perception.views.view_kernels import WORDS

POINT = np.array([[2.0, 0.0, 1.0]])
ALL_OPEN = np.full(1, 63, np.uint8)
HOLLOW = np.array([[-1e3, -1e3, -1e3, 1e3, 1e3, 1e3]])
MODEL = (np.linspace(0.9, 0.3, 17), 8, limits_m2(1.0))


def looked_from(x: float, y: float, unseen: np.ndarray, looked: np.ndarray, far_m: float = 9.0) -> int:
    camera = np.array([x, y, 1.0, 1.0, 0.0, 1.0, 0.0, 64.0])
    depth = np.full((128, 128), far_m, np.float32)
    active = np.ones(1, bool)
    return kernels.look_by_chance(depth, camera, MODEL, POINT, HOLLOW, ALL_OPEN, active, unseen, looked)


def test_a_look_lowers_unseen_by_its_chance_and_once() -> None:
    unseen, looked = np.ones(1), np.zeros(1, np.uint64)
    assert looked_from(0.0, 0.0, unseen, looked) == 1
    assert unseen[0] == pytest.approx(1.0 - MODEL[0][8])
    assert looked_from(0.1, 0.0, unseen, looked) == 0, "this look errs as the first did"
    assert looked_from(1.0, 0.0, unseen, looked) == 1
    assert unseen[0] == pytest.approx((1.0 - MODEL[0][8]) * (1.0 - MODEL[0][4]))
    assert looked_from(0.0, 0.0, np.ones(1), np.zeros(1, np.uint64), far_m=1.0) == 0, "something hides it"
    assert looked_from(-3.0, 0.0, np.ones(1), np.zeros(1, np.uint64)) == 0, "too far away"


def gains(looked: np.ndarray) -> np.ndarray:
    half = 64
    nodes = np.array([[half, half], [half + 4, half]], np.int32)
    out, height = np.zeros((2, 4, 4)), np.full((129, 129), -1.0, np.float32)
    walls = np.zeros((2, 129, 129), np.uint8)
    kernels.gain_by_chance(
        nodes, np.zeros(1, np.int32), POINT, HOLLOW, ALL_OPEN, np.array([0.5]), np.zeros((1, WORDS), np.uint64), looked,
        MODEL, 1.0, height, walls, half, out,
    )  # fmt: skip
    return out


def test_a_view_is_worth_the_chance_that_it_shows_the_target() -> None:
    out = gains(np.zeros(1, np.uint64))
    assert out[0, 0, 2] == pytest.approx(0.5 * MODEL[0][8])
    assert out[1, 0, 2] == pytest.approx(0.5 * MODEL[0][4])
    assert not out[:, 2].any(), "nothing behind the agent"
    seen = np.array([1 << look_key(2.0, 0.0, 0.0, 8, MODEL[2])], np.uint64)
    assert not gains(seen)[0].any(), "from here it was seen"
    assert gains(seen)[1, 0, 2] > 0.0


def test_what_a_view_evidently_did_not_show_is_lowered_once() -> None:
    unseen, looked, height = np.ones(1), np.zeros(1, np.uint64), np.full((129, 129), -1.0, np.float32)
    walls = np.zeros((2, 129, 129), np.uint8)
    for _ in range(2):
        kernels.fade_by_chance(
            0.0, 0.0, 1.0, (0, 4, 2), POINT, HOLLOW, ALL_OPEN, np.ones(1), MODEL, height, walls, 64, unseen, looked, 0.3
        )
    assert unseen[0] == pytest.approx(0.3)
    assert looked[0] == 1 << look_key(2.0, 0.0, 0.0, 8, MODEL[2])


@pytest.mark.parametrize("name", ["noisy", "noisy_low", "noisy_high"])
def test_small_things_must_be_looked_at_from_nearby(name: str) -> None:
    errors = read_errors(name)
    ring, jar = (Sight.of(errors, target).model[0] for target in ("ring", "coffee_bean_jar"))
    assert len(ring) < len(jar)
    for chance in (ring, jar):
        assert (np.diff(chance) <= 1e-12).all(), "never better from farther away"
        assert 0.0 < chance[-1] <= chance[0] < 1.0
    nearby = errors.right * float(errors.sighted_curve("ring", np.array([1.0]))[0])
    assert ring[4] == pytest.approx(1.0 - (1.0 - nearby) ** PASSES)
