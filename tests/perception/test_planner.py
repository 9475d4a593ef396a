from __future__ import annotations

from collections import deque

import numpy as np
import pytest
from toy import ToyEnv, two_rooms

from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, View


def started(heading: int, nav: bool = True) -> tuple[ToyEnv, SemanticMap, Planner]:
    env = ToyEnv(two_rooms(), "ring", (14, 4, heading), nav=nav)
    obs, info = env.reset()
    known = SemanticMap()
    known.update(obs, info)
    planner = Planner(info.get("nav"))
    planner.update(known)
    return env, known, planner


def slow_steps(env: ToyEnv) -> dict[tuple[int, int, int], int]:
    """Steps to each cell and heading by breadth-first search in the toy's own frame."""
    found = {env.start: 0}
    queue = deque([env.start])
    while queue:
        i, j, h = state = queue.popleft()
        ahead = (i + (1, 0, -1, 0)[h], j + (0, 1, 0, -1)[h], h)
        for following in (ahead, (i, j, (h + 1) % 4), (i, j, (h + 3) % 4)):
            a, b, _ = following
            inside = 0 <= a < env.free.shape[0] and 0 <= b < env.free.shape[1]
            if inside and env.free[a, b] and following not in found:
                found[following] = found[state] + 1
                queue.append(following)
    return found


@pytest.mark.parametrize("heading", range(4))
def test_steps_equal_a_slow_search(heading: int) -> None:
    env, _, planner = started(heading)
    expected = sorted(slow_steps(env).values())
    got = np.sort(planner.steps[planner.steps < UNREACHED])
    assert got.tolist() == expected


@pytest.mark.parametrize("heading", range(4))
def test_plans_arrive(heading: int) -> None:
    env, known, planner = started(heading)
    goals = np.argwhere(planner.steps < UNREACHED)
    for i, j, h in goals[:: len(goals) // 7]:
        env, known, planner = started(heading)
        goal = View(int(i), int(j), int(h), -30)
        plan = planner.plan(goal)
        assert len(plan) == planner.cost(goal)
        for action in plan:
            obs, _, _, _, info = env.step(int(action))
            assert not obs["collision"]
            known.update(obs, info)
        assert known.view == goal


def test_no_way_gives_no_plan() -> None:
    _, _, planner = started(0)
    assert planner.plan(View(3, 3, 0)) == []
    assert planner.cost(View(3, 3, 0)) >= UNREACHED


def test_bumps_close_the_way() -> None:
    _env, known, planner = started(0, nav=False)
    ahead = View(HALF + 1, HALF, 0)
    assert planner.cost(ahead) == 1
    known.bumped[HALF + 1, HALF] = 1
    planner.update(known)
    assert planner.cost(ahead) >= UNREACHED
