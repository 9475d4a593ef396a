from __future__ import annotations

import heapq
from collections.abc import Sequence

import cv2
import numpy as np
import pytest
from toy import Thing, ToyEnv, ToyHome, two_rooms

from ucon.perception.mapping.body import Body
from ucon.perception.mapping.fine_frontiers import (
    BONUS,
    BONUS_M,
    MOST,
    FineFrontier,
    fine_frontiers,
    labels_near,
    outline,
)
from ucon.perception.mapping.fine_kernels import EXPLORED, OBSTACLE, walk
from ucon.perception.mapping.fine_map import FineMap, cell_of
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View, frame_depth
from ucon.task.rules import RELEASED_CODE

TURN = [2, 2, 2, 2]
WALKS = ([], [2], TURN, [*TURN, 0, 0, 0], [*TURN, *[0] * 5, 2], [*TURN, *[0] * 5, 2, 1, 1, *[0] * 20])

Seen = tuple[ToyEnv, FineMap, SemanticMap, Planner]


def after(actions: Sequence[int], home: ToyHome | None = None, start: tuple[int, int, int] = (14, 4, 2)) -> Seen:
    env = ToyEnv(home or two_rooms(), "ring", start)
    obs, info = env.reset()
    fine, known, planner = FineMap(), SemanticMap(), Planner(info["nav"])
    for action in [*actions, None]:
        known.update(obs, info)
        fine.update(known.view, frame_depth(obs, info))
        if action is not None:
            obs, _, _, _, info = env.step(action)
    planner.update(known)
    return env, fine, known, planner


def found(seen: Seen) -> list[FineFrontier]:
    return fine_frontiers(*seen[1:])


@pytest.mark.parametrize("actions", WALKS)
def test_the_rules_of_the_original(actions: list[int]) -> None:
    seen = after(actions)
    _, fine, known, _ = seen
    frontiers = found(seen)
    assert len(frontiers) <= MOST == 4
    assert [f.utility for f in frontiers] == sorted((f.utility for f in frontiers), reverse=True)
    explored = cv2.morphologyEx(fine.explored, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    near_obstacle = cv2.dilate(fine.obstacle, np.ones((3, 3), np.uint8))
    for f in frontiers:
        assert f.cells > 4
        assert 0.5 < f.distance_m < 5.0
        assert f.utility == f.cells + (BONUS if f.distance_m < BONUS_M else 0.0)
        gap = np.hypot(f.xy[0] - known.view.xy[0], f.xy[1] - known.view.xy[1])
        assert f.distance_m > 0.97 * gap - 0.05
        a, b = cell_of(f.xy)
        assert explored[a, b]
        assert not near_obstacle[a, b]
        assert not explored[a - 1 : a + 2, b - 1 : b + 2].all(), "not in the interior"


@pytest.mark.parametrize("actions", WALKS)
def test_poses_were_seen_and_can_be_reached(actions: list[int]) -> None:
    seen = after(actions)
    _, fine, known, planner = seen
    for f in found(seen):
        assert known.explored[f.view.i, f.view.j]
        assert f.cost == planner.cost(f.view) < UNREACHED
        assert planner.plan(f.view) or f.view == known.view
        assert np.hypot(f.view.xy[0] - f.xy[0], f.view.xy[1] - f.xy[1]) <= 0.5
        a, b = cell_of(f.xy)
        da, db = (1, 0, -1, 0)[f.view.heading], (0, 1, 0, -1)[f.view.heading]
        ahead, behind = (
            np.mean([fine.explored[a + k * da, b + k * db] for k in steps]) for steps in (range(1, 8), range(-7, 0))
        )
        assert ahead <= behind, "looks to the unexplored side"


def test_the_first_frame_has_a_frontier() -> None:
    assert found(after([]))


def test_a_doorway_is_a_frontier_and_a_closed_room_has_none() -> None:
    closed = ToyHome(5.0, 4.0, [])
    assert found(after(TURN, closed, (8, 8, 0))) == []
    wall = [(3.95, 0.0, 4.05, 1.5), (3.95, 2.5, 4.05, 4.0)]
    env, *rest = after(TURN, ToyHome(8.0, 4.0, [], walls=wall), (3, 1, 0))
    doors = found((env, *rest))
    assert doors
    for f in doors:
        assert f.xy[0] + 0.875 > 3.9, "at the door or behind it"
        assert 0 < f.xy[1] + 0.375 < 4.0


def test_what_is_explored_inside_out_is_none() -> None:
    _, fine, known, planner = after(TURN)
    fine.cells[:] |= EXPLORED
    assert fine_frontiers(fine, known, planner) == [], "the border of the map is no frontier"


def test_obstacles_hide_frontiers() -> None:
    seen = after([])
    assert found(seen)
    _, edge = outline(seen[1], (0, *[seen[1].cells.shape[0], 0, seen[1].cells.shape[0]]))
    a, b = np.nonzero(edge)
    seen[1].cells[a, b] |= OBSTACLE
    assert found(seen) == []


def test_an_obstacle_seen_at_the_robot_does_not_lock_it_in() -> None:
    seen = after(TURN)
    before = found(seen)
    a, b = cell_of(seen[2].view.xy)
    seen[1].cells[a - 1, b - 1 : b + 2] |= OBSTACLE  # an opened door may cover the robot's own node
    seen[1].cells[a + 1, b - 1 : b + 2] |= OBSTACLE
    assert [f.xy for f in found(seen)] == [f.xy for f in before]


@pytest.mark.parametrize("look", [-30, 0, 30])
def test_other_rules_put_the_camera_elsewhere(look: int) -> None:
    body = Body.under(RELEASED_CODE)
    fine = FineMap(body)
    fine.update(View(HALF, HALF, 0, look), np.full((128, 128), 2.0, np.float32))
    wall = np.argwhere(fine.obstacle)
    assert set(wall[:, 0].tolist()) == {cell_of((2.0, 0.0))[0]}
    assert len(wall) >= 78, "4 m wide"


def test_the_first_group_counts_too() -> None:
    """The original code leaves it out by mistake, so it would never find a single frontier."""
    home = ToyHome(8.0, 4.0, [], walls=[(3.95, 0.0, 4.05, 1.5), (3.95, 2.5, 4.05, 4.0)])
    counts = {len(found(after([*TURN, *[0] * k], home, (3, 7, 0)))) for k in (0, 2, 4)}
    assert 0 not in counts


def test_unreachable_frontiers_are_dropped() -> None:
    seen = after(TURN)
    assert found(seen)
    seen[3].steps[:] = UNREACHED
    assert found(seen) == []


def test_same_twice_and_the_map_is_left_alone() -> None:
    first, second = after(WALKS[3]), after(WALKS[3])
    before = first[1].cells.copy()
    assert found(first) == found(first) == found(second)
    np.testing.assert_array_equal(first[1].cells, before)


def test_labels_near() -> None:
    _, _, known, _ = after(WALKS[-1])
    everything = labels_near(known, known.view.xy, 40.0)
    assert set(everything) == {
        name for track, name in enumerate(known.category) if name and not known.kind[track] and known.seen(track)
    }
    assert not {"floors", "walls", "ceilings"} & set(everything)
    track = known.category.index("coffee_table")
    x0, y0, _, _, y1, _ = known.box[track]
    near = labels_near(known, (x0 - 0.95, 0.5 * (y0 + y1)), 2.0)
    assert "coffee_table" in near
    assert "coffee_table" not in labels_near(known, (x0 - 1.05, 0.5 * (y0 + y1)), 2.0)
    assert set(labels_near(known, (x0, y0))) <= set(labels_near(known, (x0, y0), 6.0)) <= set(everything)
    largest = max(everything, key=lambda name: max(_area(known, t) for t in known.instances[name] if known.seen(t)))
    assert everything[0] == largest, "what covers most comes first"


def _area(known: SemanticMap, track: int) -> float:
    x0, y0, _, x1, y1, _ = known.box[track]
    return float((x1 - x0) * (y1 - y0))


def test_each_label_once_and_equals_by_name() -> None:
    chairs = [Thing("straight_chair", (x, 3.0, 0.0, x + 0.4, 3.4, 0.9)) for x in (1.0, 2.0, 3.0)]
    _, _, known, _ = after(TURN, ToyHome(5.0, 4.0, chairs), (8, 8, 0))
    assert labels_near(known, known.view.xy, 8.0) == ["straight_chair"]
    known.box[: known.n_tracks] = np.array([0, 0, 0, 1, 1, 1])
    known.category[known.instances["straight_chair"][1]] = "armchair"
    assert labels_near(known, known.view.xy, 8.0) == ["armchair", "straight_chair"]


def marched(blocked: np.ndarray, start: tuple[int, int], limit: float) -> np.ndarray:
    """Reference: fast marching with a heap."""
    n = len(blocked)
    out, done = np.full((n, n), np.inf), np.zeros((n, n), bool)
    out[start] = 0.0
    heap = [(0.0, *start)]
    while heap:
        _, i, j = heapq.heappop(heap)
        if done[i, j]:
            continue
        done[i, j] = True
        for p, q in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if not (0 < p < n - 1 and 0 < q < n - 1) or blocked[p, q] or done[p, q]:
                continue
            u, v = sorted((min(out[p - 1, q], out[p + 1, q]), min(out[p, q - 1], out[p, q + 1])))
            way = u + 1.0 if v - u >= 1.0 else 0.5 * (u + v + np.sqrt(2.0 - (u - v) ** 2))
            if way < out[p, q] and way <= limit:
                out[p, q] = way
                heapq.heappush(heap, (way, p, q))
    return out


@pytest.mark.parametrize("share", [0.0, 0.1, 0.35])
def test_ways_are_those_of_fast_marching(share: float) -> None:
    n = 81
    blocked = (np.random.default_rng(3).random((n, n)) < share).astype(np.uint8)
    blocked[40, 40] = 0
    out, waiting = np.empty((n, n), np.float32), np.zeros((n, n), bool)
    walk(blocked, 40, 40, 36.0, out, np.empty(n * n, np.int32), waiting)
    expected = marched(blocked, (40, 40), 36.0)
    assert not waiting.any()
    both = np.isfinite(out) & np.isfinite(expected)
    assert (np.isfinite(out) != np.isfinite(expected)).sum() <= 2
    np.testing.assert_allclose(out[both], expected[both], atol=0.05)
    if share == 0.0:
        i, j = np.nonzero(both)
        straight = np.hypot(i - 40, j - 40)
        far = straight > 10
        assert (np.abs(out[i, j] / np.maximum(straight, 1) - 1)[far] < 0.09).all()
