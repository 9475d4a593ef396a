"""The image of the map that the habit policy reads."""

from __future__ import annotations

import numpy as np

from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View
from ucon.perception.views.viewpoints import Viewpoints
from ucon.search.map_raster import CHANNELS, PIXEL_M, SIDE, map_raster

MIDDLE = SIDE // 2


def drawn(known: SemanticMap, xyz: np.ndarray | None = None, weight: np.ndarray | None = None) -> dict[str, np.ndarray]:
    points = np.zeros((0, 3)) if xyz is None else xyz
    image = map_raster(known, Viewpoints(3.0), points, np.zeros(len(points)) if weight is None else weight, None)
    return dict(zip(CHANNELS, image, strict=True))


def a_map(heading: int = 0) -> SemanticMap:
    known = SemanticMap()
    known.views.append(View(HALF, HALF, heading))
    return known


def test_an_empty_map_is_empty() -> None:
    seen = drawn(a_map())
    for name in ("explored", "floor", "walls", "blocked", "near", "visited", "mass", "kitchen"):
        assert not seen[name].any(), name
    assert (seen["stale"] == 255).all()


def test_what_lies_ahead_is_ahead_whatever_the_heading() -> None:
    """A spot 2 m ahead and 1 m to the left of the agent."""
    for heading, (di, dj) in enumerate([(8, 4), (-4, 8), (-8, -4), (4, -8)]):
        known = a_map(heading)
        known.explored[HALF + di, HALF + dj] = 1
        image = drawn(known)["explored"]
        assert np.unravel_index(image.argmax(), image.shape) == (MIDDLE + 2 / PIXEL_M, MIDDLE + 1 / PIXEL_M)
        assert image.max() == 64  # one cell of nine, with a quarter of the weight


def test_a_mirrored_home_gives_a_mirrored_image() -> None:
    draw, plain = np.random.default_rng(0), a_map()
    plain.explored[:] = draw.random(plain.explored.shape) < 0.5
    plain.walls[:] = draw.random(plain.walls.shape) < 0.1
    mirror = a_map()
    mirror.explored[:] = plain.explored[:, ::-1]
    mirror.walls[0] = plain.walls[0][:, ::-1]
    mirror.walls[1, :, :-1] = plain.walls[1][:, -2::-1]  # the wall between j and j + 1
    for name, image in drawn(plain).items():
        assert (drawn(mirror)[name] == image[:, ::-1]).all(), name


def test_mass_shows_where_it_lies_and_more_is_brighter() -> None:
    xyz = np.array([[1.0, 0.0, 0.5], [-3.0, 2.0, 0.5], [500.0, 0.0, 0.5]])
    image = drawn(a_map(), xyz, np.array([0.1, 0.001, 1.0]))["mass"]
    ahead, behind = image[MIDDLE + 2, MIDDLE], image[MIDDLE - 6, MIDDLE + 4]
    assert ahead > behind > 0
    assert (image > 0).sum() == 2
