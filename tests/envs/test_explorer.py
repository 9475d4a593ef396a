"""The explorer carries out choices: when it walks, looks around, opens, asks again and takes the target."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "perception"))
from toy import ToyEnv, two_rooms  # (the path above)

from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.semantic_map import View
from ucon.search import STRATEGIES, Decision, Explorer, Manner, Views
from ucon.search.explorer import Interrupt
from ucon.task.actions import Action
from ucon.task.episode import Episode


@dataclass
class Played:
    """One episode: all actions, the view before each, and the decisions by the number of the next action."""

    explorer: Explorer
    actions: list[Action] = field(default_factory=list)
    views: list[View] = field(default_factory=list)
    chosen: dict[int, tuple[Decision, int]] = field(default_factory=dict)
    taking_from: int = -1
    seen_from: int = -1
    collisions: int = 0
    info: Any = None


def play(env: Any, make: Callable[[Any], Any], manner: Manner, start: Any = None, seed: int = 0) -> Played:
    """Choose at random until the end of the episode."""
    obs, info = env.reset(options=start) if start else env.reset()
    explorer = Explorer(info, make(info), manner, seed)
    out, draw, over = Played(explorer), np.random.default_rng(seed), False
    while not over:
        action = explorer.look(obs, info)
        if out.seen_from < 0 and any(explorer.map.seen(t) for t in explorer.map.instances.get(explorer.target, ())):
            out.seen_from = len(out.actions)
        if action is None:
            decision = explorer.decision()
            number = int(draw.integers(len(decision.candidates)))
            out.chosen[len(out.actions)] = decision, number
            action = explorer.choose(number)
        if explorer.taking and out.taking_from < 0:
            out.taking_from = len(out.actions)
        out.views.append(explorer.map.view)
        out.actions.append(action)
        obs, _, done, truncated, info = env.step(int(action))
        out.collisions += int(obs["collision"][0])
        over = done or truncated
    out.info = info
    return out


def toy(target: str) -> ToyEnv:
    return ToyEnv(two_rooms(), target, (12, 4, 1), size=64)


def in_homes(
    episodes: tuple[Episode, ...], make: Callable[[Any], Any], manner: Manner, every: int = 3, **options: Any
) -> list[Played]:
    env = UcONEnv(episodes, observe="symbolic", detector=True, **options)
    return [play(env, make, manner, {"episode": number}) for number in range(1, len(episodes), every)]


def arrivals(played: Played) -> list[tuple[int, int, View]]:
    """For each finished walk: the action at which it arrives, that of the next choice (or the end), and the goal."""
    marks = [*played.chosen, played.taking_from if played.taking_from >= 0 else len(played.actions)]
    out = []
    for first, last in pairwise(marks):
        decision, number = played.chosen[first]
        goal = decision.candidates[number].view
        there = [k for k in range(first, min(last + 1, len(played.views))) if played.views[k] == goal]
        if there:
            out.append((there[0], last, goal))
    return out


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_the_first_step_is_the_plans(strategy: str, episodes: tuple[Episode, ...]) -> None:
    """The plan is carried out from its first action on, also if that is a step ahead."""
    ahead = 0
    for played in in_homes(episodes, STRATEGIES[strategy], Manner()):
        assert played.collisions == 0
        for first, (decision, number) in played.chosen.items():
            candidate = decision.candidates[number]
            if first + candidate.cost < len(played.views) and candidate.cost:
                between = played.taking_from < 0 or first + candidate.cost < played.taking_from
                assert not between or played.views[first + candidate.cost] == candidate.view
                ahead += played.actions[first] == Action.MOVE_AHEAD
    assert ahead > 0


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_goals_were_seen_before(strategy: str, episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic", detector=True)
    for number in range(len(episodes)):
        obs, info = env.reset(options={"episode": number})
        explorer, over = Explorer(info, STRATEGIES[strategy](info)), False
        while not over:
            if (action := explorer.look(obs, info)) is None:
                decision = explorer.decision()
                assert decision.candidates
                assert all(explorer.map.explored[c.view.i, c.view.j] for c in decision.candidates)
                action = explorer.choose(decision.step % len(decision.candidates))
            obs, _, done, truncated, info = env.step(int(action))
            over = done or truncated


def test_it_opens_on_arrival_once_a_pose(episodes: tuple[Episode, ...]) -> None:
    opened = 0
    for played in in_homes(episodes, STRATEGIES["landmarks"], Manner()):
        poses = [view for view, action in zip(played.views, played.actions, strict=True) if action == Action.OPEN]
        assert len(poses) == len(set(poses))
        stands = [(goal.i, goal.j, first, last) for first, last, goal in arrivals(played)]
        for k, action in enumerate(played.actions):
            if action == Action.OPEN and played.chosen and k >= min(played.chosen):
                here = played.views[k]
                assert any((here.i, here.j) == (i, j) and first <= k < last for i, j, first, last in stands)
                opened += 1
    assert opened > 0
    for played in in_homes(episodes, STRATEGIES["landmarks"], Manner(opens=False)):
        assert Action.OPEN not in played.actions


def test_opening_shows_what_is_inside() -> None:
    """The cup is in the cupboard, so only an explorer that opens it can find it."""
    assert play(toy("coffee_cup"), STRATEGIES["landmarks"], Manner()).info["success"]
    assert play(toy("coffee_cup"), STRATEGIES["landmarks"], Manner(opens=False)).seen_from < 0


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_it_looks_around_on_arrival(strategy: str, episodes: tuple[Episode, ...]) -> None:
    whole = 0
    for played in in_homes(episodes, STRATEGIES[strategy], Manner()):
        for first, last, goal in arrivals(played):
            if last in played.chosen:
                assert {view.heading for view in played.views[first : last + 1]} == {0, 1, 2, 3}
                assert {(view.i, view.j) for view in played.views[first : last + 1]} == {(goal.i, goal.j)}
                whole += 1
    assert whole > 0
    for played in in_homes(episodes, STRATEGIES[strategy], Manner(look_around=False, opens=False)):
        for first, last, _ in arrivals(played):
            if last in played.chosen:
                assert last - first <= 1  # a goal right here costs a turn


@pytest.mark.parametrize("steps", [5, 7, 10])
def test_a_new_choice_is_due_after_so_many_steps(steps: int, episodes: tuple[Episode, ...]) -> None:
    early = whole = 0
    for played in in_homes(episodes, STRATEGIES["views"], Manner(replan_steps=steps), every=1):
        marks = [*played.chosen]
        for first, last in pairwise(marks):
            decision, number = played.chosen[first]
            candidate = decision.candidates[number]
            if candidate.cost > steps:
                assert last - first == steps
                early += 1
            elif candidate.cost == steps:  # it arrives on the last step, and looks around
                assert played.views[first + steps] == candidate.view
                assert last - first >= steps + 3
                whole += 1
    assert early > 0
    assert whole > 0


@pytest.mark.parametrize("interrupt", get_args(Interrupt))
def test_what_ends_the_search(interrupt: Interrupt, episodes: tuple[Episode, ...]) -> None:
    taken = passed = 0
    make = STRATEGIES["views" if interrupt == "chosen" else "frontiers"]
    for played in in_homes(episodes, make, Manner(interrupt=interrupt), every=1):
        first, target = played.taking_from, played.explorer.target
        passed += played.seen_from >= 0 and not 0 <= first <= played.seen_from
        if first < 0:
            continue
        taken += 1
        if interrupt == "always":
            assert first == played.seen_from
        elif interrupt == "chosen":
            decision, number = played.chosen[first]
            assert target in [name for name, _ in decision.candidates[number].things]
        else:
            stands = [(0, min(played.chosen, default=first)), *((a, b) for a, b, _ in arrivals(played))]
            assert any(a <= first <= b for a, b in stands)
    assert taken > 0
    assert (passed > 0) == (interrupt != "always")


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_it_does_without_the_true_free_space(strategy: str, episodes: tuple[Episode, ...]) -> None:
    """Cells not known to be blocked are tried; a collision is remembered and walked around."""
    for played in in_homes(episodes, STRATEGIES[strategy], Manner(), planner="observed"):
        assert len({(view.i, view.j) for view in played.views}) > 20 or played.info["episode_metrics"]["success"]
        metrics = played.info["episode_metrics"]
        assert metrics["collisions"] == played.collisions < 0.2 * metrics["steps"]


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_the_seed_decides_what_is_drawn(strategy: str, episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, observe="symbolic", detector=True)
    runs = [play(env, STRATEGIES[strategy], Manner(), {"episode": 1}, seed).actions for seed in (1, 1, 2)]
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]


def test_a_decision_is_the_same_however_often_it_is_asked_for() -> None:
    env = toy("teapot")
    obs, info = env.reset()
    explorer = Explorer(info, Views())
    while (action := explorer.look(obs, info)) is not None:
        obs, _, _, _, info = env.step(int(action))
    assert explorer.decision() is explorer.decision()
    before = [c.view for c in explorer.decision().candidates]
    obs, _, _, _, info = env.step(int(Action.ROTATE_LEFT))
    explorer.look(obs, info)
    after = explorer.decision()
    assert after.number == 0
    assert sorted(v.heading for v in before) == sorted(c.view.heading for c in after.candidates)
    assert after.step == 4
