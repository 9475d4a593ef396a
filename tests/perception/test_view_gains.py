"""The worth of views, against a plain projection of the same points into the same images."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ucon.perception.mapping.map_kernels import ALL_OPEN, CELL_M
from ucon.perception.views.space_kernels import space_gain
from ucon.perception.views.view_kernels import (
    PITCHES_DEG,
    WORDS,
    fade_places,
    open_gain,
    place_gain,
    sight,
)

HALF = 20
SIZE = 2 * HALF + 1
CAMERA_M, REACH_M = 1.25, 3.0
NODES = [(HALF + i, HALF + j) for i in (-3, 0, 2) for j in (-2, 0, 4)]
#: Share of half the image that counts: things cut off by its edge are not seen.
EDGE = 0.95


class Home:
    """A floor without walls; things may be put on it."""

    def __init__(self, nodes: list[tuple[int, int]]) -> None:
        self.index = np.full((SIZE, SIZE), -1, np.int32)
        for row, node in enumerate(nodes):
            self.index[node] = row
        self.height = np.full((SIZE, SIZE), -1.0, np.float32)
        self.walls = np.zeros((2, SIZE, SIZE), np.uint8)
        self.hidden: np.ndarray | None = None
        self.nodes, self.n = np.array(nodes, np.int32).reshape(-1, 2), len(nodes)

    def places(self, xyz: np.ndarray, weight: np.ndarray, headings: int = 4) -> np.ndarray:
        out = np.zeros((self.n, headings, 4))
        hollow, faces = np.zeros((len(xyz), 6)), np.full(len(xyz), ALL_OPEN, np.uint8)
        if self.hidden is None:
            self.hidden = np.zeros((len(xyz), WORDS), np.uint64)
        rows = np.flatnonzero(weight > 0).astype(np.int32)
        place_gain(
            self.nodes, rows, xyz, hollow, faces, weight, self.hidden, REACH_M, CAMERA_M, self.height, self.walls, HALF,
            out,
        )  # fmt: skip
        return out

    def opens(self, boxes: np.ndarray, weight: np.ndarray, reach_m: float, whole: bool = False) -> np.ndarray:
        out = np.zeros((self.n, 4, 4))
        open_gain(self.index, boxes, whole, weight, reach_m, CAMERA_M, self.height, self.walls, HALF, out)
        return out


def places(n: int = 40) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    return np.ascontiguousarray(rng.uniform((-2.0, -2.0, 0.0), (2.0, 2.0, 2.0), (n, 3))), rng.uniform(0.5, 2.0, n)


def shown(node: tuple[int, int], xyz: np.ndarray, headings: int = 4) -> np.ndarray:
    """(H, 4, n) whether the view at a heading and pitch contains a point that is near enough to be recognised."""
    edge = EDGE * np.tan(np.pi / headings)
    from_camera = xyz - np.array([(node[0] - HALF) * CELL_M, (node[1] - HALF) * CELL_M, CAMERA_M])
    near = np.hypot(from_camera[:, 0], from_camera[:, 1]) <= REACH_M
    out = np.zeros((headings, 4, len(xyz)), bool)
    for heading in range(headings):
        yaw = heading * 2 * np.pi / headings
        for number, pitch in enumerate(np.deg2rad(PITCHES_DEG)):
            axis = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
            left = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
            optical, side, up = (from_camera @ v for v in (axis, left, np.cross(axis, left)))
            inside = (np.abs(side) <= edge * optical) & (np.abs(up) <= edge * optical)
            out[heading, number] = near & inside & (optical > 0.15) & (optical <= REACH_M)
    return out


@pytest.mark.parametrize("headings", [4, 6])
def test_views_are_worth_the_places_in_their_picture(headings: int) -> None:
    """With four headings the view is 90 degrees wide, with six it is 60."""
    xyz, weight = places()
    found = Home(NODES).places(xyz, weight, headings)
    for row, node in enumerate(NODES):
        assert found[row] == pytest.approx(shown(node, xyz, headings) @ weight)
    assert (found > 0).mean() > 0.2


def test_every_view_and_every_place_counts_by_itself() -> None:
    """Also with walls and things in the way, and with places without weight among the others."""
    xyz, weight = places()
    weight[::3] = 0.0
    weight[1::7] = 0.01

    def furnished(nodes: list[tuple[int, int]]) -> Home:
        home = Home(nodes)
        home.walls[0, HALF + 1, HALF - 3 : HALF + 1] = 1
        home.walls[1, HALF - 4 : HALF - 1, HALF + 1] = 1
        home.height[HALF - 1, HALF + 2] = 1.6
        return home

    together = furnished(NODES).places(xyz, weight)
    alone = np.concatenate([furnished([node]).places(xyz, weight) for node in NODES])
    assert np.array_equal(together, alone)
    parts = sum(furnished(NODES).places(xyz[k : k + 1], weight[k : k + 1]) for k in range(len(xyz)))
    assert together == pytest.approx(parts)
    free = Home(NODES).places(xyz, weight)
    assert (together <= free + 1e-12).all()
    assert together.sum() < free.sum()


def test_what_was_hidden_once_is_not_asked_for_again_and_what_was_in_sight_may_be_hidden_later() -> None:
    xyz, weight = places()
    home = Home(NODES)
    first = home.places(xyz, weight)
    assert np.array_equal(home.places(xyz, weight), first)
    assert home.hidden is not None
    hidden = home.hidden.copy()
    home.walls[0, HALF + 1, HALF - 3 : HALF + 1] = 1
    walled = home.places(xyz, weight)
    assert walled.sum() < first.sum()
    assert (home.hidden & hidden == hidden).all()
    assert (home.hidden != hidden).any()
    anew = Home(NODES)
    anew.walls[:] = home.walls
    assert np.array_equal(anew.places(xyz, weight), walled)


def test_containers_count_within_reach_of_an_open() -> None:
    """A box that begins 0.5 m ahead of the middle node; for other nodes the gap to the box counts."""
    box, reach_m = np.array([[0.5, -0.3, 0.0, 1.1, 0.3, 0.8], [9.0, 9.0, 0.0, 9.5, 9.5, 1.0]]), 1.0
    nodes = [(HALF, HALF), (HALF - 2, HALF), (HALF - 3, HALF), (HALF + 3, HALF - 5), (HALF - 2, HALF - 3)]
    found = Home(nodes).opens(box, np.array([2.0, 3.0]), reach_m)
    assert found[0].max() == 2.0
    assert found[0, 0, PITCHES_DEG.index(0)] == 2.0, "looking at it"
    assert found[0, 2].max() == 0.0, "looking away"
    assert found[1].max() == 2.0, "one metre, no more"
    assert found[2].max() == 0.0
    assert found[3].max() == 2.0, "0.95 m aside"
    assert found[4].max() == 0.0, "one metre and half a metre aside"
    alone = [Home([node]).opens(box, np.array([2.0, 3.0]), reach_m)[0] for node in nodes]
    assert np.array_equal(found, np.stack(alone))
    assert not Home(nodes).opens(box, np.array([0.0, 0.0]), reach_m).any()
    both = np.vstack([box[1:], box[:1]])
    assert np.array_equal(Home(nodes).opens(both, np.array([0.0, 2.0]), reach_m), found), "an empty one hides no other"


def test_a_whole_container_does_not_hide_itself() -> None:
    """A fridge seen from all sides fills its cells to its full height, and these are in front of its centre."""
    box, nodes = np.array([[0.3, -0.5, 0.0, 1.5, 0.5, 1.7]]), [(HALF, HALF)]
    home = Home(nodes)
    home.height[HALF + 1 : HALF + 7, HALF - 2 : HALF + 3] = 1.7
    assert home.opens(box, np.array([2.0]), 1.0).max() == 0.0
    assert home.opens(box, np.array([2.0]), 1.0, whole=True)[0, 0, PITCHES_DEG.index(0)] == 2.0
    home.walls[0, HALF, :] = 1
    assert home.opens(box, np.array([2.0]), 1.0, whole=True).max() == 0.0, "through a wall"


@pytest.mark.parametrize("faded", [0, 2])
def test_places_that_a_view_showed_in_vain_fade(faded: int) -> None:
    xyz, weight = places()
    weight[5] = 0.0
    node, unseen = NODES[4], np.ones(len(xyz))
    home = Home([node])
    x, y = (node[0] - HALF) * CELL_M, (node[1] - HALF) * CELL_M
    hollow, faces = np.zeros((len(xyz), 6)), np.full(len(xyz), ALL_OPEN, np.uint8)
    fade_places(
        x, y, CAMERA_M, (1, 4, faded), xyz, hollow, faces, weight, REACH_M, home.height, home.walls, HALF, unseen, 0.25
    )  # fmt: skip
    in_view = shown(node, xyz)[1, faded] & (weight > 0)
    assert in_view.any()
    assert unseen == pytest.approx(np.where(in_view, 0.25, 1.0))


def test_sight_ends_at_walls_and_at_what_is_higher_than_the_line() -> None:
    home = Home([])

    def seen(height: float, wall: bool, z: float = 1.0) -> bool:
        home.height[:] = -1.0
        home.walls[:] = 0
        home.height[HALF + 4, HALF] = height
        home.walls[0, HALF + 4, HALF] = wall
        return bool(sight(0.0, 0.0, CAMERA_M, 2.0, 0.0, z, home.height, home.walls, HALF))

    assert seen(-1.0, False)
    assert not seen(-1.0, True)
    assert seen(0.9, False), "half way the line is at 1.125 m"
    assert not seen(1.3, False)
    assert not seen(0.9, False, z=0.1), "and at 0.675 m where it looks down"
    home.height[:], home.walls[:] = -1.0, 0
    home.height[HALF + 8, HALF] = 2.0
    assert sight(0.0, 0.0, CAMERA_M, 2.0, 0.0, 1.0, home.height, home.walls, HALF), "a thing does not hide itself"


def test_a_wall_right_before_the_camera_hides_and_one_right_behind_it_does_not() -> None:
    for ahead in (True, False):
        home = Home([])
        home.walls[0, HALF if ahead else HALF - 1, HALF] = 1
        assert sight(0.0, 0.0, CAMERA_M, 2.0, 0.0, 1.0, home.height, home.walls, HALF) != ahead
        assert sight(0.0, 0.0, CAMERA_M, -2.0, 0.0, 1.0, home.height, home.walls, HALF) == ahead


def gained(weight: tuple[float, float], **cells: Any) -> np.ndarray:
    """(4,) square metres by heading, seen from the middle of an unexplored home, except for what ``cells`` change."""
    explored, height = np.zeros((SIZE, SIZE), np.uint8), np.full((SIZE, SIZE), -1.0, np.float32)
    near, stale, interest = (np.full((SIZE, SIZE), v, np.float32) for v in (1e3, 1.0, 1.0))
    arrays = {"explored": explored, "height": height, "near": near, "stale": stale, "interest": interest}
    for name, (where, value) in cells.items():
        arrays[name][where] = value
    out = np.zeros((1, 4))
    space_gain(np.array([[HALF, HALF]], np.int32), tuple(arrays.values()), (12, REACH_M), weight, out)
    return out[0]


EVERYWHERE = (slice(None), slice(None))
AHEAD = (slice(HALF + 1, None), slice(None))


def test_space_counts_alike_in_all_directions_and_less_the_deeper() -> None:
    around = gained((1.0, 0.0))
    assert around == pytest.approx([around[0]] * 4, rel=0.05)
    quarter = np.pi * (12 * CELL_M) ** 2 / 4
    assert 0.1 * quarter < around[0] < 0.5 * quarter
    assert gained((2.0, 0.0)) == pytest.approx(2 * around)


def test_space_is_worth_what_it_is_of_interest_and_not_yet_stale() -> None:
    around = gained((1.0, 0.0))
    assert gained((1.0, 0.0), interest=(EVERYWHERE, 0.5)) == pytest.approx(0.5 * around)
    assert gained((1.0, 0.0), stale=(EVERYWHERE, 0.25)) == pytest.approx(0.25 * around)
    ahead = gained((1.0, 0.0), interest=(AHEAD, 0.0))
    assert ahead[0] == 0.0
    assert ahead[2] == pytest.approx(around[2])


def test_explored_space_counts_where_it_was_seen_from_too_far() -> None:
    known = {"explored": (EVERYWHERE, 1)}
    assert not gained((1.0, 0.0), **known).any()
    far = gained((0.0, 1.0), **known)
    area = np.pi * REACH_M**2 / 4
    assert far == pytest.approx([area] * 4, rel=0.15)
    assert not gained((0.0, 1.0), **known, near=(EVERYWHERE, REACH_M)).any()


def test_space_behind_what_is_tall_is_not_seen() -> None:
    around = gained((1.0, 0.0))
    walled = gained((1.0, 0.0), height=((HALF + 2, slice(None)), 2.0))
    assert walled[0] < 0.3 * around[0]
    assert walled[2] == pytest.approx(around[2])
    low = gained((1.0, 0.0), height=((HALF + 2, slice(None)), 0.8))
    assert low == pytest.approx(around)
