from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from toy import CELL, ToyEnv, two_rooms

from ucon.perception.mapping import fine_kernels as kernels
from ucon.perception.mapping.body import PAPER_BODY
from ucon.perception.mapping.fine_kernels import EXPLORED, FINE_M, OBSTACLE, PER_CELL, VISITED
from ucon.perception.mapping.fine_map import FINE_HALF, FINE_SIZE, FineMap, cell_of, middle_of
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SIZE, SemanticMap, View, camera_of, frame_depth

TOUR = [2, 2, 2, 2, *[0] * 5, 2, 1, 1, *[0] * 20, 4, 1, 1, 1, 1, 3, *[0] * 6, 1, 0, 0, 0, 1, 4, 1, 1]
#: The longest side of any home.
LONGEST_M = 29.0


@pytest.fixture(params=[0, 1, 2, 3], scope="module")
def toured(request: pytest.FixtureRequest) -> tuple[ToyEnv, SemanticMap, FineMap]:
    return tour((14, 4, request.param))


def tour(start: tuple[int, int, int]) -> tuple[ToyEnv, SemanticMap, FineMap]:
    env, known, fine = ToyEnv(two_rooms(), "ring", start), SemanticMap(), FineMap()
    obs, info = env.reset()
    for action in [*TOUR, None]:
        known.update(obs, info)
        fine.update(known.view, frame_depth(obs, info))
        if action is not None:
            obs, _, _, _, info = env.step(action)
    return env, known, fine


def to_world(env: ToyEnv, cells: np.ndarray) -> np.ndarray:
    """Centres (n, 2) of cells in the toy's frame."""
    x, y = ((cells - FINE_HALF) * FINE_M).T
    c, s = (1, 0, -1, 0)[env.start[2]], (0, 1, 0, -1)[env.start[2]]
    return np.stack([(env.start[0] + 0.5) * CELL + c * x - s * y, (env.start[1] + 0.5) * CELL + s * x + c * y], 1)


def test_sizes() -> None:
    assert pytest.approx(PER_CELL) == CELL_M / FINE_M
    assert FINE_SIZE == SIZE * PER_CELL
    assert FINE_HALF * FINE_M > LONGEST_M, "every home fits from every start"
    assert FineMap().nbytes < 5e6
    for i in (0, HALF, 200):
        for d in (-0.12, -0.06, 0.0, 0.06, 0.12):
            assert cell_of(((i - HALF) * CELL_M + d, 0.0))[0] // PER_CELL == i, "fine cells tile the coarse ones"
    assert middle_of(*cell_of((1.23, -4.56))) == pytest.approx((1.23, -4.56), abs=0.5 * FINE_M + 1e-9)


def test_obstacles_are_where_things_stand(toured: tuple[ToyEnv, SemanticMap, FineMap]) -> None:
    env, _, fine = toured
    boxes = np.array([t.box for t in env.things if t.container < 0])
    solid = boxes[(boxes[:, 5] > kernels.OBSTACLE_M) & (boxes[:, 2] < 1.75)]
    at = to_world(env, np.argwhere(fine.obstacle))
    gap = np.maximum(np.maximum(solid[None, :, :2] - at[:, None], at[:, None] - solid[None, :, 3:5]), 0).max(2).min(1)
    assert len(at) > 400
    assert (gap < FINE_M).mean() > 0.995
    assert gap.max() < 2 * FINE_M, "joined points of two things in line"


def test_the_seen_sides_of_walls_have_no_gaps(toured: tuple[ToyEnv, SemanticMap, FineMap]) -> None:
    env, _, fine = toured
    at = to_world(env, np.argwhere(fine.obstacle))
    for axis, other, face in ((0, 1, 4.95), (1, 0, 0.05)):
        along = np.sort(at[np.abs(at[:, other] - face) < 0.06, axis])
        along = along[(along > 1.5) & (along < 4.5)]
        assert len(along) > 40
        assert max(b - a for a, b in pairwise(along)) < 3 * FINE_M


def test_explored_agrees_with_the_coarse_map(toured: tuple[ToyEnv, SemanticMap, FineMap]) -> None:
    env, known, fine = toured
    cells = np.argwhere(fine.explored)
    coarse = known.explored[cells[:, 0] // PER_CELL, cells[:, 1] // PER_CELL] > 0
    assert coarse.mean() > 0.97
    at = to_world(env, cells)
    assert ((at > -0.1) & (at < (env.home.width + 0.1, env.home.depth + 0.1))).all(), "nothing beyond the outer walls"
    assert len(cells) * FINE_M**2 > 0.6 * env.home.width * env.home.depth


def test_visited_cells(toured: tuple[ToyEnv, SemanticMap, FineMap]) -> None:
    _, known, fine = toured
    for view in known.views:
        a, b = cell_of(view.xy)
        assert fine.visited[a - 1 : a + 2, b - 1 : b + 2].all()
    assert fine.visited.sum() == 9 * len({(view.i, view.j) for view in known.views})
    assert not (fine.cells & ~np.uint8(OBSTACLE | EXPLORED | VISITED)).any(), "nothing of a single frame is left"


def test_extent_holds_everything(toured: tuple[ToyEnv, SemanticMap, FineMap]) -> None:
    fine = toured[2]
    a0, a1, b0, b1 = fine.extent()
    assert np.count_nonzero(fine.cells[a0:a1, b0:b1]) == np.count_nonzero(fine.cells)
    rows, columns = np.flatnonzero(fine.cells.any(1)), np.flatnonzero(fine.cells.any(0))
    assert (a0, a1, b0, b1) == (rows[0], rows[-1] + 1, columns[0], columns[-1] + 1)


def test_reset_leaves_nothing_behind() -> None:
    fine = tour((14, 4, 0))[2]
    first = fine.cells.copy()
    fine.reset()
    assert not fine.cells.any()
    env, known = ToyEnv(two_rooms(), "ring", (14, 4, 0)), SemanticMap()
    obs, info = env.reset()
    for action in [*TOUR, None]:
        known.update(obs, info)
        fine.update(known.view, frame_depth(obs, info))
        if action is not None:
            obs, _, _, _, info = env.step(action)
    np.testing.assert_array_equal(fine.cells, first)


@pytest.mark.parametrize(("pitch", "cleared"), [(0, True), (-30, False)])
def test_only_a_level_frame_clears_what_is_gone(pitch: int, cleared: bool) -> None:
    fine = FineMap()
    fine.update(View(HALF, HALF, 0), np.full((128, 128), 2.0, np.float32))  # a wall 2 m ahead
    wall = fine.obstacle.astype(bool)
    assert wall.any()
    assert set(np.argwhere(wall)[:, 0].tolist()) == {cell_of((2.0, 0.0))[0]}
    view = View(HALF, HALF, 0, pitch)
    fine.update(view, _floor(view))
    left = fine.obstacle.astype(bool)
    assert left[wall].all() != cleared
    if cleared:
        assert left.sum() < 0.3 * wall.sum()


def test_far_outside_nothing_happens() -> None:
    fine = FineMap()
    for view in (View(0, 0, 2), View(SIZE - 1, SIZE - 1, 0), View(0, SIZE - 1, 1, -30)):
        fine.update(view, np.full((128, 128), 3.0, np.float32))
    fine.update(View(HALF, HALF, 0), np.zeros((128, 128), np.float32))
    assert fine.extent()[0] <= 4
    assert fine.extent()[3] >= FINE_SIZE - 4
    fine.reset()
    assert not fine.cells.any()


def _floor(view: View) -> np.ndarray:
    """Depth of an endless floor."""
    camera = camera_of(view, np.zeros((128, 128), np.float32), PAPER_BODY)
    up = (63.5 - np.arange(128)) / 64.0
    rise = camera[6] + camera[5] * up
    with np.errstate(divide="ignore"):
        rows = np.where(rise < 0, -camera[2] / rise, 0.0)
    return np.repeat(rows[:, None], 128, 1).astype(np.float32)


@pytest.mark.parametrize("pitch", [0, -30, 30, -60])
@pytest.mark.parametrize("kind", ["noise", "smooth"])
def test_kernels_equal_a_plain_reference(pitch: int, kind: str) -> None:
    rng = np.random.default_rng(7 + abs(pitch))
    fine, expected = FineMap(), np.zeros((FINE_SIZE, FINE_SIZE), np.uint8)
    for heading in (0, 1, 2, 3, 1):
        view = View(HALF + int(rng.integers(-9, 9)), HALF + int(rng.integers(-9, 9)), heading, pitch)
        depth = rng.uniform(0.2, 7.0, (128, 128))
        if kind == "smooth":  # slanted planes, partly without a return
            row = 1.0 / np.abs(rng.uniform(0.2, 1.0) + np.linspace(-0.15, 0.4, 128) * rng.uniform(-1, 1))
            depth = np.repeat(row[None], 128, 0)
            depth[:, 40:50], depth[:9] = 0.0, np.inf
        depth = depth.astype(np.float32)
        fine.update(view, depth)
        _reference(expected, camera_of(view, depth, PAPER_BODY), depth)
        a, b = cell_of(view.xy)
        expected[a - 1 : a + 2, b - 1 : b + 2] |= EXPLORED | VISITED
    assert np.count_nonzero(expected) > 2000
    different = np.argwhere(fine.cells != expected)
    assert len(different) <= 2, f"{len(different)} cells"  # rounding at the border of two cells


def _reference(cells: np.ndarray, camera: np.ndarray, depth: np.ndarray) -> None:
    x, y, eye, c, s, cp, sp, focal = camera
    d = np.where(np.isfinite(depth), depth, 1e9).astype(float)
    side = np.broadcast_to((np.arange(128) - 63.5)[None] / focal, d.shape)
    up = (63.5 - np.arange(128))[:, None] / focal
    ahead, rise = np.broadcast_to(cp - sp * up, d.shape), np.broadcast_to(sp + cp * up, d.shape)

    def cell(f: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (
            np.floor((x + c * f + s * g) / FINE_M + 0.5).astype(int) + FINE_HALF,
            np.floor((y + s * f - c * g) / FINE_M + 0.5).astype(int) + FINE_HALF,
        )

    z = eye + d * rise
    high, low = np.zeros(cells.shape, bool), np.zeros(cells.shape, bool)
    used = (d > 0.5) & (d < np.where(z < 0.25, 4.5, 5.0)) & (z > -0.4) & (z < 2.0)
    seen = cell(d[used] * ahead[used], d[used] * side[used])
    cells[seen] |= EXPLORED
    low[tuple(v[z[used] < 0.25] for v in seen)] = True
    tall = (z[used] >= 0.25) & (z[used] < eye + 0.5)
    high[tuple(v[tall] for v in seen)] = True
    for v in range(2, 128, 4):
        for u in range(1, 127):
            three = d[v, u - 1 : u + 2]
            flat = (three > 0.5).all() and (three < 5.0).all() and abs((1 / three) @ np.array([1, -2, 1])) <= 0.003
            if not flat or not 0.25 <= z[v, u] < min(eye + 0.5, 2.0):
                continue
            for k in (-1, 1):
                f = np.array([d[v, u], 0.5 * (d[v, u] + d[v, u + k])]) * ahead[v, u]
                g = np.array([d[v, u] * side[v, u], 0.5 * (d[v, u] * side[v, u] + d[v, u + k] * side[v, u + k])])
                n = int(max(abs(f[1] - f[0]), abs(g[1] - g[0])) / FINE_M + 0.5)
                t = np.arange(1, n + 1) / max(n, 1)
                high[cell(f[0] + t * (f[1] - f[0]), g[0] + t * (g[1] - g[0]))] = True
    cells[high] |= OBSTACLE | EXPLORED
    if sp == 0.0:
        grown = high.copy()
        for a in (-1, 0, 1):
            for b in (-1, 0, 1):
                grown |= np.roll(high, (a, b), (0, 1))
        cells[low & ~grown] &= 255 - OBSTACLE
    _reference_lines(cells, camera, d, ahead, rise, side)


def _reference_lines(
    cells: np.ndarray, camera: np.ndarray, d: np.ndarray, ahead: np.ndarray, rise: np.ndarray, side: np.ndarray
) -> None:
    x, y, eye, c, s = camera[:5]
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(rise > 0, np.minimum(4.5, min(0.5, 2.0 - eye) * ahead / rise), 4.5)
        column = np.trunc(side / ahead * 64 + 128).astype(int)
    reach = np.minimum(d * ahead, far)
    for k in range(256):
        chosen = (column == k) & (ahead >= 0.2)
        chosen[1::2] = False
        longest = reach[chosen].max(initial=0.0)
        if longest > 0.02:
            slope = (k - 127.5) / 64
            step = 1.0 / max(1.0, abs(slope))
            n = int((longest - 0.02) / FINE_M / step)
            a = np.cumsum([x / FINE_M + FINE_HALF + 0.5, *[(c + s * slope) * step] * n])
            b = np.cumsum([y / FINE_M + FINE_HALF + 0.5, *[(s - c * slope) * step] * n])
            cells[a.astype(int), b.astype(int)] |= EXPLORED


def test_a_cell_is_noted_once_a_frame() -> None:
    cells, touched = np.zeros((4, 4), np.uint8), np.zeros(2, np.int32)
    low, high = EXPLORED | kernels._LOW, EXPLORED | OBSTACLE | kernels._HIGH
    for first, then in ((low, high), (high, low)):
        cells[:] = 0
        assert kernels._mark(cells, 1, 2, first, touched, 0) == 1
        assert kernels._mark(cells, 1, 2, then, touched, 1) == 1
        assert cells[1, 2] == first | then
    assert touched.tolist() == [6, 0]
    assert kernels._mark(cells, 0, 0, low, touched, 2) == 2, "no room is left"


@pytest.mark.parametrize("along_a", [True, False])
def test_surfaces_leave_the_border_of_the_map_free(along_a: bool) -> None:
    """A wall seen at a flat angle that continues beyond the edge of a map of 30 x 30 cells."""
    tangent = (np.arange(128) - 63.5) / 64
    depth = np.repeat((0.25 / np.maximum(1.0 - 0.9 * tangent, 0.1))[None], 128, 0).astype(np.float32)
    camera = np.array(
        [0.0, 1.6, 1.25, 1.0, 0.0, 1.0, 0.0, 64.0] if along_a else [0.0, 0.0, 1.25, 0.0, 1.0, 1.0, 0.0, 64.0]
    )
    marked = []
    for n in (30, 60):
        cells = np.zeros((n, n), np.uint8)
        kernels._surfaces(depth, camera, 2, cells, np.zeros(65536, np.int32), 0)
        marked.append(cells if along_a else cells.T)
    small, large = marked
    assert large[29, :30].any(), "the wall goes on there"
    assert small.any()
    assert not small[[0, -1]].any()
    assert not small[:, [0, -1]].any()
    assert (small[1:-1, 1:-1] == large[1:29, 1:29]).all()
