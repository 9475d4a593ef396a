"""Scan conversion in blocks equals the rule applied pixel by pixel, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.core.rng import stream
from ucon.sim.render.parts import new_scratch
from ucon.sim.render.spans import BLOCK_PX, fill

WIDTH, HEIGHT = 75, 70
F = np.float32
HALF = F(0.5)


def one_by_one(
    polygon: np.ndarray, plane: tuple, window: tuple, depths: np.ndarray, faces: np.ndarray, face: int
) -> None:
    """The rule in plain form: a pixel is inside if its centre is between the edges that its row crosses."""
    for y in range(window[1], window[3]):
        sides = [None, None]
        for k in range(polygon.shape[1]):
            (x0, y0), (x1, y1) = polygon[:, k], polygon[:, (k + 1) % polygon.shape[1]]
            side = int(y0 > y1)
            if side:
                x0, y0, x1, y1 = x1, y1, x0, y0
            if int(max(y0, -HALF) + HALF) <= y < int(max(y1, -HALF) + HALF):
                sides[side] = x0 + (F(y) + HALF - y0) * ((x1 - x0) / (y1 - y0))
        if None in sides:
            continue
        begin, end = (int(max(side, -HALF) + HALF) for side in sides)
        for x in range(max(begin, window[0]), min(end, window[2])):
            z = plane[2] + plane[1] * F(y) + plane[0] * F(x)
            if z > depths[y, x] or (z == depths[y, x] and face < faces[y, x]):
                depths[y, x], faces[y, x] = z, face


@pytest.mark.parametrize("size", [0.6, 3.0, 20.0, 90.0])
def test_blocks_draw_what_the_rule_says(size: float) -> None:
    random = stream(3, "spans", str(size))
    scratch = new_scratch()
    polygon, sides, spans = scratch[4], scratch[5], scratch[6]
    depths = np.zeros(WIDTH * HEIGHT + int(BLOCK_PX), np.float32)
    faces = np.full(WIDTH * HEIGHT + int(BLOCK_PX), -1, np.int32)
    expected = (
        depths[: WIDTH * HEIGHT].reshape(HEIGHT, WIDTH).copy(),
        faces[: WIDTH * HEIGHT].reshape(HEIGHT, WIDTH).copy(),
    )
    for face in random.permutation(150 if size > 1 else 1500):
        m = int(random.integers(3, 9))
        turn = np.sort(random.uniform(0, 2 * np.pi, m))[::-1]
        middle = random.uniform(-5, 80, (2, 1))
        polygon[:, :m] = middle + size * random.uniform(0.2, 1.0, (2, 1)) * np.stack([np.cos(turn), np.sin(turn)])
        left, top = (int(v) for v in random.integers(0, 20, 2))
        window = (left, top, int(random.integers(left, WIDTH + 1)), int(random.integers(top, HEIGHT + 1)))
        plane = tuple(F(v) for v in (*random.integers(-1, 2, 2) * 0.01, random.integers(1, 4)))
        one_by_one(polygon[:, :m].copy(), plane, window, *expected, int(face))
        rows = polygon[1, :m]
        first = max(int(max(rows.min(), -HALF) + HALF), window[1])
        last = min(int(max(rows.max(), -HALF) + HALF), window[3])
        fill(
            face,
            m,
            plane,
            (first, last),
            tuple(np.int32(v) for v in window),
            polygon,
            sides,
            spans,
            (depths, faces, WIDTH),
        )
    np.testing.assert_array_equal(depths[: WIDTH * HEIGHT].reshape(HEIGHT, WIDTH), expected[0])
    np.testing.assert_array_equal(faces[: WIDTH * HEIGHT].reshape(HEIGHT, WIDTH), expected[1])
    assert (expected[1] >= 0).sum() >= 10
