"""UcONWaypoint-v0: contract, accounting of primitive steps, and no privileged fact in what a policy gets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.envs.recorder import recorded
from tests.envs.test_ucon_env import same
from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.ucon_env import UcONEnv
from ucon.envs.waypoint import STRATEGIES, Manner
from ucon.envs.waypoint.env import UcONWaypointEnv
from ucon.envs.waypoint.features import COLUMNS
from ucon.objects.catalogue import catalogue
from ucon.perception.candidates import KINDS
from ucon.task.actions import Action
from ucon.task.episode import Episode

INFO = {
    "target", "episode", "task", "context", "habit_level", "habits", "habit_rows", "nav", "camera_m", "fov_deg",
    "episode_metrics", "is_success",
    "candidates", "primitive_steps", "invalid",
}  # fmt: skip
Steps = list[tuple[Any, ...]]


def at_random(draw: np.random.Generator) -> Callable[[Any], int]:
    return lambda obs: int(draw.choice(np.flatnonzero(obs["action_mask"])))


def rollout(env: UcONWaypointEnv, choose: Callable[[Any], int], **options: Any) -> Steps:
    seen: Steps = [env.reset(**options)]
    while len(seen) < 2 or not (seen[-1][2] or seen[-1][3]):
        seen.append(env.step(choose(seen[-1][0])))
    return seen


def gone(episode: Episode) -> Episode:
    """The same home without the target."""
    objects = list(episode.arrangement.objects)
    objects[episode.target] = replace(objects[episode.target], position=(0.0, 0.0, -50.0))
    return replace(episode, arrangement=replace(episode.arrangement, objects=tuple(objects)))


@pytest.mark.filterwarnings("ignore:.*")
@pytest.mark.parametrize("options", [{"observe": "symbolic"}, {"observe": "pixels", "task": "released_code"}])
def test_gymnasium_check_env(options: dict[str, Any]) -> None:
    check_env(gym.make("UcONWaypoint-v0", render_mode="rgb_array", **options).unwrapped)


def test_torchrl_check_env_specs() -> None:
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    check_env_specs(GymWrapper(gym.make("UcONWaypoint-v0")))


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_torchrl_draws_candidates_only(strategy: str, episodes: tuple[Episode, ...]) -> None:
    import torch
    from torchrl.envs import ActionMask, GymWrapper, TransformedEnv

    made = GymWrapper(gym.make("UcONWaypoint-v0", episodes=episodes, strategy=strategy))
    env = TransformedEnv(made, ActionMask(mask_key="action_mask"))
    torch.manual_seed(0)
    env.set_seed(0)
    most = 0
    for _ in range(3):
        drawn = env.rollout(12)
        mask = drawn["action_mask"].bool()
        assert (mask & drawn["action"].bool()).sum(-1).tolist() == [1] * len(drawn)
        most = max(most, int(mask.sum(-1).max()))
    assert 1 < most < mask.shape[-1]


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_two_environments_with_one_seed_are_identical(strategy: str, episodes: tuple[Episode, ...]) -> None:
    def play(draws: int) -> Steps:
        env = UcONWaypointEnv(episodes, strategy=strategy, seed=draws)
        return rollout(env, at_random(np.random.default_rng(1)), seed=3)

    a, b = play(0), play(0)
    assert len(a) == len(b)
    assert all(same(x, y) for x, y in zip(a, b, strict=True))


def test_an_episode_does_not_depend_on_what_was_played_before(episodes: tuple[Episode, ...]) -> None:
    env = UcONWaypointEnv(episodes, strategy="views")
    play = lambda: rollout(env, at_random(np.random.default_rng(1)), options={"episode": 2})  # noqa: E731
    first = play()
    rollout(env, at_random(np.random.default_rng(2)), options={"episode": 1})
    assert all(same(x, y) for x, y in zip(first, play(), strict=True))


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_episodes_are_the_sum_of_their_primitive_steps(strategy: str, episodes: tuple[Episode, ...]) -> None:
    """Steps and rewards add up, every choice costs a step, the planner runs into nothing; a replay says the same."""
    env = UcONWaypointEnv(episodes, strategy=strategy)
    inner, plain = recorded(env), UcONEnv(episodes, observe="symbolic")
    for number in range(0, len(episodes), 2):
        seen = rollout(env, at_random(np.random.default_rng(number)), options={"episode": number})
        metrics = seen[-1][4]["episode_metrics"]
        steps = [step[4]["primitive_steps"] for step in seen[1:]]
        assert min(steps) >= 1
        assert sum(steps) == metrics["steps"] == len(inner.actions) == seen[-1][0]["step"] <= 300
        assert metrics["collisions"] == inner.collisions == 0
        assert all(step[0] in env.observation_space for step in seen)
        assert not any(step[4]["invalid"] for step in seen[1:])
        plain.reset(options={"episode": number})
        replay = [plain.step(action) for action in inner.actions]
        assert sum(step[1] for step in seen[1:]) == pytest.approx(sum(float(step[1]) for step in replay))
        assert replay[-1][4]["episode_metrics"] == metrics
        assert seen[-1][2:4] == replay[-1][2:4]


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_candidates_are_told_as_they_are(strategy: str, episodes: tuple[Episode, ...]) -> None:
    """Rows and mask are those of the candidates, their nodes were seen, and what is numbered is what stands there."""
    env = UcONWaypointEnv(episodes, strategy=strategy)
    names, kinds, ahead = tuple(catalogue().names), len(KINDS), len(KINDS) + COLUMNS.index("ahead_m")
    obs, info = env.reset(options={"episode": 1})
    choose, offered, over = at_random(np.random.default_rng(0)), 0, False
    while not over:
        found = info["candidates"]
        assert obs["action_mask"].tolist() == [1] * len(found) + [0] * (256 - len(found))
        assert not obs["candidates"][len(found) :].any()
        assert (obs["candidate_things"][len(found) :] == -1).all()
        known = env._explorer.map  # type: ignore[union-attr]
        for row, things, candidate in zip(obs["candidates"], obs["candidate_things"], found, strict=False):
            assert known.explored[candidate.view.i, candidate.view.j]
            assert np.flatnonzero(row[:kinds]).tolist() == [KINDS.index(candidate.kind)]
            there = {candidate.category} | {name for name, _ in candidate.things}
            assert {names[k] for k in things if k >= 0} <= there
            away = np.subtract(candidate.view.xy, known.view.xy)
            assert np.hypot(*row[ahead : ahead + 2]) == pytest.approx(np.hypot(*away), abs=1e-4)
        offered += len(found)
        obs, _, terminated, truncated, info = env.step(choose(obs))
        over = terminated or truncated
    assert offered > 5
    assert len(env.category_table) == len(names)


def test_positions_are_in_the_agents_frame(episodes: tuple[Episode, ...]) -> None:
    """A direction to the front lies ahead, one to the left on the left."""
    env = UcONWaypointEnv(episodes, strategy="views")
    sides = set()
    for number in range(len(episodes)):
        obs, info = env.reset(options={"episode": number})
        here = env._explorer.map.view  # type: ignore[union-attr]
        for row, candidate in zip(obs["candidates"], info["candidates"], strict=False):
            ahead, left = row[len(KINDS) : len(KINDS) + 2]
            side = (candidate.view.heading - here.heading) % 4
            along = (ahead, left, -ahead, -left)[side]
            assert along > 0
            assert along + 1e-5 >= max(abs(ahead), abs(left))
            sides.add(side)
    assert sides == {0, 1, 2, 3}


def test_an_invalid_choice_costs_one_step(episodes: tuple[Episode, ...]) -> None:
    env = UcONWaypointEnv(episodes, strategy="frontiers")
    inner = recorded(env)
    _, info = env.reset(options={"episode": 1})
    for invalid in (len(info["candidates"]), 255):
        before, cost = len(inner.actions), [c.cost for c in info["candidates"]]
        _, _, terminated, truncated, info = env.step(invalid)
        assert info["invalid"]
        assert inner.actions[before:] == [Action.ROTATE_LEFT]
        assert (terminated, truncated) == (False, False)
        assert cost != [c.cost for c in info["candidates"]]  # measured anew from the new heading
    assert not env.step(0)[4]["invalid"]


@pytest.mark.parametrize("choose", [lambda obs: 0, lambda obs: 255], ids=["first", "invalid"])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_stubborn_policy_comes_to_an_end(strategy: str, choose: Any, episodes: tuple[Episode, ...]) -> None:
    env = UcONWaypointEnv(episodes, strategy=strategy, manner=Manner(look_around=False, opens=False))
    seen = rollout(env, choose, options={"episode": 3})
    assert len(seen) <= 301
    assert all(step[4]["primitive_steps"] >= 1 for step in seen[1:])


def test_a_target_in_view_at_the_start_is_taken_by_any_choice(episodes: tuple[Episode, ...]) -> None:
    plain, found = UcONEnv(episodes, observe="symbolic"), 0
    for episode in episodes:
        plain.reset(options={"episode": episode})
        for digit in episode.solution[:-1]:
            plain.step(int(digit))
        pose = plain.search.pose
        if pose.pitch_deg or episode.target_object.relation == "inside":
            continue
        near = replace(episode, start=replace(episode.start, i=pose.i, j=pose.j, heading=pose.heading))
        env = UcONWaypointEnv([near])
        obs, info = env.reset(options={"episode": 0})
        assert info["candidates"] == ()
        assert obs["action_mask"].tolist() == [1] + [0] * 255
        assert obs["step"] == info["primitive_steps"] == 0
        _, reward, terminated, _, info = env.step(found)
        assert terminated
        assert info["episode_metrics"]["success"]
        assert reward == pytest.approx(10 - 0.01 * info["primitive_steps"])
        found += 1
    assert found >= 2


def test_nothing_privileged_is_given(episodes: tuple[Episode, ...]) -> None:
    """With the target taken out of the world, all is the same until the target would have come into view."""
    compared = 0
    for strategy in STRATEGIES:
        envs = [UcONWaypointEnv(episodes, strategy=strategy, habit_level="full") for _ in range(2)]
        inner = [recorded(env) for env in envs]
        for episode in episodes[::3]:
            choose = at_random(np.random.default_rng(0))
            steps = [env.reset(options={"episode": e}) for env, e in zip(envs, (episode, gone(episode)), strict=True)]
            while not inner[0].saw:
                assert same(*steps)
                assert set(steps[0][0]) == set(envs[0].observation_space)
                assert set(steps[0][-1]) <= INFO
                compared += 1
                action = choose(steps[0][0])
                steps = [env.step(action) for env in envs]
                if steps[0][2] or steps[0][3]:
                    break
    assert compared > 30


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"strategy": "frontier"}, "unknown strategy 'frontier': did you mean frontiers"),
        ({"detector": None}, "detector=None: candidates come from what is detected"),
        ({"detector": False}, "name a detector"),
        ({"max_candidates": 1, "strategy": "views"}, "candidates, expected at most 1; raise max_candidates"),
        ({"habit_level": "ful"}, "did you mean full"),
    ],
)
def test_bad_options_end_in_one_clear_line(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message) as caught:
        rollout(UcONWaypointEnv(**options), lambda obs: 0, options={"episode": 0})
    assert "\n" not in str(caught.value)


def test_a_step_before_the_reset_is_refused() -> None:
    with pytest.raises(EpisodeError, match=r"call reset\(\) first"):
        UcONWaypointEnv().step(0)
