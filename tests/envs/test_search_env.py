"""UcONSearch-v0: contract, equality with the agent that chooses by gain over cost, no privileged information."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.envs.choosing import at_random, gone, rollout
from tests.envs.recorder import recorded
from tests.envs.test_ucon_env import same
from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.search.env import Returns, UcONSearchEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.belief.target_belief import Locations
from ucon.search.searcher import LOYALTY
from ucon.search.view_tokens import IS_KEPT, VISITED
from ucon.task.episode import Episode

INFO = {
    "target", "episode", "task", "context", "habit_level", "habits", "habit_rows", "nav", "camera_m", "fov_deg",
    "episode_metrics", "is_success", "invalid",
}  # fmt: skip
Steps = list[tuple[Any, ...]]


def greedy(obs: Any) -> int:
    score = obs["prior"] + np.log(LOYALTY) * obs["views"][:, IS_KEPT]
    return int(np.where(obs["action_mask"] > 0, score, -np.inf).argmax())


@pytest.mark.filterwarnings("ignore:.*")
def test_gymnasium_check_env() -> None:
    check_env(gym.make("UcONSearch-v0", render_mode="rgb_array").unwrapped)


def test_torchrl_check_env_specs() -> None:
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    check_env_specs(GymWrapper(gym.make("UcONSearch-v0")))


def test_an_episode_does_not_depend_on_what_was_played_before(episodes: tuple[Episode, ...]) -> None:
    env = UcONSearchEnv(episodes)
    play = lambda env: rollout(env, at_random(np.random.default_rng(1)), options={"episode": 2})  # noqa: E731
    first = play(env)
    rollout(env, at_random(np.random.default_rng(2)), options={"episode": 1})
    for again in (play(env), play(UcONSearchEnv(episodes))):
        assert len(first) == len(again)
        assert all(same(x, y) for x, y in zip(first, again, strict=True))


def test_views_say_where_it_has_stood(episodes: tuple[Episode, ...]) -> None:
    env, told = UcONSearchEnv(episodes), set()
    draw = at_random(np.random.default_rng(0))
    obs, _ = env.reset(options={"episode": 0})
    for _ in range(12):
        assert env._tokens is not None
        assert env._searcher is not None
        for row, choice in zip(obs["views"], env._tokens.choices, strict=False):
            stood = env._searcher.map.visited[choice.view.i, choice.view.j] > 0
            assert row[VISITED] == stood
            told.add(bool(stood))
        obs, _, *over, _ = env.step(draw(obs))
        if any(over):
            obs, _ = env.reset(options={"episode": 1})
    assert told == {False, True}


def test_episodes_are_worth_what_the_returns_say_and_replay_alike(episodes: tuple[Episode, ...]) -> None:
    returns = Returns(spl=2.0, success=1.0, speed=0.5)
    env, plain = UcONSearchEnv(episodes, returns=returns), UcONEnv(episodes, observe="symbolic")
    inner, found = recorded(env), 0
    for number in range(0, len(episodes), 2):
        seen = rollout(env, greedy, options={"episode": number})
        metrics = seen[-1][4]["episode_metrics"]
        assert metrics["steps"] == len(inner.actions)
        assert all(step[0] in env.observation_space for step in seen)
        assert not any(step[1] for step in seen[1:-1])
        assert not any(step[4]["invalid"] for step in seen[1:])
        worth = 2.0 * metrics["spl"] + 1.0 + 0.5 * (1 - metrics["steps"] / 300) if metrics["success"] else 0.0
        assert seen[-1][1] == pytest.approx(worth)
        found += metrics["success"]
        plain.reset(options={"episode": number})
        assert [plain.step(action) for action in inner.actions][-1][4]["episode_metrics"] == metrics
    assert found


def test_views_are_told_as_they_are(episodes: tuple[Episode, ...]) -> None:
    """Rows and mask match the choices, best first except for the view it is on its way to; the rest is zero."""
    env, asked = UcONSearchEnv(episodes), 0
    obs, _ = env.reset(options={"episode": 1})
    choose, over = at_random(np.random.default_rng(0)), False
    while not over:
        tokens, n = env._tokens, int(obs["action_mask"].sum())
        assert tokens is not None
        assert n == len(tokens.choices) > 1
        assert not obs["views"][n:].any()
        np.testing.assert_allclose(np.exp(obs["prior"][:n]), [c.score for c in tokens.choices], rtol=1e-4)
        here = env._searcher.map.view  # type: ignore[union-attr]
        for row, choice in zip(obs["views"], tokens.choices, strict=False):
            away = np.subtract(choice.view.xy, here.xy)
            assert 5.0 * np.hypot(row[10], row[11]) == pytest.approx(np.hypot(*away), abs=1e-4)
            assert choice.view != here
        asked += 1
        obs, _, terminated, truncated, _ = env.step(choose(obs))
        over = terminated or truncated
    assert asked > 5


def test_habits_change_what_is_seen(episodes: tuple[Episode, ...]) -> None:
    read = {
        level: UcONSearchEnv(episodes, habit_level=level).reset(options={"episode": 0})[0] for level in ("none", "gt")
    }
    assert not read["none"]["habits_mask"].any()
    assert read["gt"]["habits_mask"].any()
    assert not np.array_equal(read["none"]["prior"], read["gt"]["prior"])


def test_an_invalid_choice_costs_one_step(episodes: tuple[Episode, ...]) -> None:
    env = UcONSearchEnv(episodes)
    inner = recorded(env)
    obs, _ = env.reset(options={"episode": 1})
    before, beyond = len(inner.actions), len(obs["action_mask"]) - 1
    assert env.step(beyond)[4]["invalid"]
    assert len(inner.actions) == before + 1


def test_nothing_privileged_is_given(episodes: tuple[Episode, ...]) -> None:
    """Without the target in the world, everything is the same until the target would have come into view."""
    envs = [UcONSearchEnv(episodes, habit_level="full") for _ in range(2)]
    inner, compared = [recorded(env) for env in envs], 0
    for episode in episodes[::3]:
        steps: list[Any] = [
            env.reset(options={"episode": e}) for env, e in zip(envs, (episode, gone(episode)), strict=True)
        ]
        while not inner[0].saw:
            assert same(*steps)
            assert set(steps[0][0]) == set(envs[0].observation_space)
            assert set(steps[0][-1]) <= INFO
            compared += 1
            action = greedy(steps[0][0])
            steps = [env.step(action) for env in envs]
            if steps[0][2] or steps[0][3]:
                break
    assert compared > 20


def test_places_may_come_from_elsewhere(episodes: tuple[Episode, ...]) -> None:
    nowhere = Locations(("bed",), np.zeros((1, 4)))
    told, read = (UcONSearchEnv(episodes, locate=locate) for locate in (lambda info: nowhere, None))
    a, b = (env.reset(options={"episode": 0})[0] for env in (told, read))
    assert not np.array_equal(a["prior"], b["prior"])


def test_at_level_context_its_text_follows_the_list_of_habits(episodes: tuple[Episode, ...]) -> None:
    env, lists = UcONSearchEnv(episodes, habit_level="context"), []
    for number in range(len(episodes)):
        for obs, *_ in rollout(env, greedy, options={"episode": number}):
            told = obs["habits"][obs["habits_mask"] > 0]
            if not lists or not np.array_equal(told, lists[-1]):
                lists.append(told)
    assert len(lists) > len(episodes)


def test_bad_use_ends_in_one_clear_line() -> None:
    with pytest.raises(ConfigError, match="views are valued by what is detected"):
        UcONSearchEnv(detector=None)
    with pytest.raises(EpisodeError, match=r"call reset\(\) first"):
        UcONSearchEnv().step(0)
