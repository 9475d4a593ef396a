"""A robot's paths on the lattice of its moves, against a slow search over positions, and obstacles that it sees."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from ucon.core.compass import DIRECTIONS, TAN_HALF, heading_to, sector
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.obstacles import ObstacleMap
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View, camera_of, view_of_pose
from ucon.task.actions import Action
from ucon.task.rules import REAL_ROBOT

BODY = Body.under(REAL_ROBOT)


def standing(x: float = 0.03, y: float = -0.02, heading: int = 1) -> SemanticMap:
    """The map of a robot that has explored a square of 3 m, with a pillar 0.75 m ahead."""
    known = SemanticMap(BODY)
    known.views.append(View(HALF, HALF, heading, 0, (x, y, heading * np.pi / 3)))
    known.explored[HALF - 6 : HALF + 7, HALF - 6 : HALF + 7] = 1
    assert known.obstacles is not None
    known.obstacles.bump((x + 0.5 * np.cos(np.pi / 3), y + 0.5 * np.sin(np.pi / 3)), (0.5, float(np.sqrt(0.75))))
    return known


def walked(view: View, actions: list[Action]) -> tuple[float, float, int]:
    assert view.at is not None
    x, y, h = view.at[0], view.at[1], view.heading
    for action in actions:
        if action == Action.MOVE_AHEAD:
            x, y = x + 0.25 * DIRECTIONS[6, h, 0], y + 0.25 * DIRECTIONS[6, h, 1]
        elif action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            h = (h + (1 if action == Action.ROTATE_LEFT else 5)) % 6
    return x, y, h


def slow_steps(known: SemanticMap, free: np.ndarray) -> dict[tuple[int, int, int], int]:
    """The fewest actions to every cell and heading, by a search over rounded positions."""
    view = known.view
    assert view.at is not None
    i0, i1, j0, j1 = known.extent(margin=6)
    start = (round(view.at[0], 6), round(view.at[1], 6), view.heading)
    found, queue, best = {start: 0}, deque([start]), dict[tuple[int, int, int], int]()
    while queue:
        x, y, h = state = queue.popleft()
        i, j = int(np.floor(x / 0.25 + 0.5)) + HALF, int(np.floor(y / 0.25 + 0.5)) + HALF
        best[i, j, h] = min(best.get((i, j, h), UNREACHED), found[state])
        for action in (Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            a, b, turned = walked(View(0, 0, h, 0, (x, y, 0.0)), [action])
            i, j = int(np.floor(a / 0.25 + 0.5)) + HALF, int(np.floor(b / 0.25 + 0.5)) + HALF
            following = (round(a, 6), round(b, 6), turned)
            fine = int(np.floor(a / 0.05 + 0.5)) + 642, int(np.floor(b / 0.05 + 0.5)) + 642
            if action == Action.MOVE_AHEAD and not (i0 <= i < i1 and j0 <= j < j1 and free[fine]):
                continue
            if following not in found:
                found[following] = found[state] + 1
                queue.append(following)
    return best


def test_steps_equal_a_slow_search() -> None:
    known = standing()
    planner = Planner(None, BODY)
    planner.update(known)
    assert known.obstacles is not None
    expected = slow_steps(known, known.obstacles.free())
    got = {(i, j, h): int(planner.steps[i, j, h]) for i, j, h in np.argwhere(planner.steps < UNREACHED).tolist()}
    assert got == expected
    assert len(got) > 500


def test_plans_arrive_around_what_blocks_the_way() -> None:
    known, planner = standing(), Planner(None, BODY)
    planner.update(known)
    assert known.obstacles is not None
    free = known.obstacles.free()
    for i, j, h in np.argwhere(planner.steps < UNREACHED)[::23].tolist():
        goal = View(i, j, h, -30)
        plan = planner.plan(goal)
        assert len(plan) == planner.cost(goal)
        for k in range(len(plan)):
            x, y, _ = walked(known.view, plan[: k + 1])
            assert free[int(np.floor(x / 0.05 + 0.5)) + 642, int(np.floor(y / 0.05 + 0.5)) + 642]
        x, y, heading = walked(known.view, plan)
        assert view_of_pose(np.array([x, y, heading * np.pi / 3, -np.pi / 6]), BODY.camera_m, BODY) == goal


def test_a_plan_forgets_the_one_before() -> None:
    known, planner = standing(), Planner(None, BODY)
    planner.update(known)
    known.views.append(View(HALF + 2, HALF, 0, 0, (0.5, 0.01, 0.0)))
    planner.update(known)
    anew = Planner(None, BODY)
    anew.update(known)
    assert np.array_equal(planner.steps, anew.steps)
    assert planner.plan(View(HALF + 4, HALF, 0)) == [Action.MOVE_AHEAD] * 2


def test_who_stands_in_an_obstacle_gets_away() -> None:
    known = standing()
    assert known.obstacles is not None
    for turn in range(6):
        known.obstacles.bump((-0.1 * DIRECTIONS[6, turn, 0], -0.1 * DIRECTIONS[6, turn, 1]), tuple(DIRECTIONS[6, turn]))
    planner = Planner(None, BODY)
    planner.update(known)
    assert (planner.steps < UNREACHED).sum() > 100


def wall(distance_m: float, heading: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Depth and camera of a level view of a wall across a floor."""
    view = View(HALF, HALF, heading, 0, (0.0, 0.0, heading * np.pi / 3))
    depth = np.full((128, 128), distance_m, np.float32)
    camera = camera_of(view, depth, BODY)
    up = (64.0 - np.arange(128) - 0.5) / camera[7]
    floor = np.where(up < 0, BODY.camera_m / np.maximum(-up, 1e-9), 1e9)
    return np.minimum(depth, floor[:, None]).astype(np.float32), camera


@pytest.mark.parametrize("heading", range(6))
def test_a_wall_is_an_obstacle_and_the_floor_before_it_is_none(heading: int) -> None:
    depth, camera = wall(2.0, heading)
    seen = ObstacleMap()
    seen.add(depth, camera)
    cells = np.argwhere(seen.votes >= 4) - 642
    ahead = cells @ DIRECTIONS[6, heading] * 0.05
    assert len(cells) > 20
    assert ahead == pytest.approx(np.full(len(cells), 2.0), abs=0.06)
    free = seen.free(0.18)
    at = np.floor(np.outer([1.7, 1.9], DIRECTIONS[6, heading]) / 0.05 + 0.5).astype(int) + 642
    assert free[tuple(at.T)].tolist() == [True, False]


def test_what_is_too_far_or_not_read_says_nothing_and_floor_takes_back() -> None:
    seen = ObstacleMap()
    seen.add(*wall(3.8))
    depth, camera = wall(2.0)
    seen.add(np.zeros_like(depth), camera)
    assert not (seen.votes >= 4).any()
    seen.add(depth, camera)
    assert (seen.votes >= 4).any()
    for _ in range(30):
        seen.add(*wall(3.4))
    assert not (seen.votes >= 4)[642 : 642 + 50].any()


def test_headings_are_directions_and_sectors() -> None:
    for n in (4, 6):
        for h in range(n):
            angle = 2 * np.pi * h / n
            assert DIRECTIONS[n, h] == pytest.approx((np.cos(angle), np.sin(angle)))
            assert heading_to(float(np.cos(angle + 0.3)), float(np.sin(angle + 0.3)), n) == h
            assert sector((h / n + 0.4 / n) % 1.0, n) == h
        assert TAN_HALF[n] == pytest.approx(np.tan(np.pi / n))
