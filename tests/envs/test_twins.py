"""Twins: one search scored for targets at other places."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest

from ucon.core.errors import EpisodeError
from ucon.envs.search.env import UcONSearchEnv
from ucon.envs.search.twin_env import TwinSearchEnv
from ucon.learning.decisions.decisions import by_gain_over_cost
from ucon.search.beyond import MOVES
from ucon.search.view_tokens import moves_to
from ucon.task.sets import load_episodes

EPISODES = load_episodes("mini")


def searched(env: TwinSearchEnv, episode: int) -> tuple[float, list[float], bool]:
    """Play by gain over cost: sum of rewards, probability left after each step, and whether the target was found."""
    observation, _ = env.reset(options={"episode": episode})
    total, left, named, over = 0.0, [env.twins.left], False, False
    while not over:
        observation, reward, terminated, truncated, _ = env.step(by_gain_over_cost(observation))
        over, total = terminated or truncated, total + float(reward)
        left.append(env.twins.left)
        named |= bool(env._searcher.map.instances.get(EPISODES[episode].target_category))  # type: ignore[union-attr]
    return total, left, named


@pytest.fixture(scope="module")
def env() -> TwinSearchEnv:
    return TwinSearchEnv(EPISODES, habit_level="retrieval")


@pytest.mark.parametrize("episode", [0, 7])
def test_a_search_goes_on_to_the_end_and_finds_more_and_more_places(env: TwinSearchEnv, episode: int) -> None:
    total, left, _ = searched(env, episode)
    assert left[0] <= 1.0
    assert (np.diff(left) <= 1e-12).all()
    assert left[-1] < 0.6
    assert 0.1 < total <= 1.0 - left[-1] + 1e-9
    assert env.env.ledger.steps == env.env.rules.max_steps


def test_the_target_itself_is_hidden() -> None:
    alone = [e for e in EPISODES if sum(o.category == e.target_category for o in e.arrangement.objects) == 1][:2]
    for episode in alone:
        env = TwinSearchEnv([episode], habit_level="gt")
        observation, over = env.reset()[0], False
        while not over:
            observation, _, terminated, truncated, _ = env.step(by_gain_over_cost(observation))
            over = terminated or truncated
            seen = env._searcher.map.instances.get(episode.target_category, [])  # type: ignore[union-attr]
            assert env.env.search.target not in [
                k for k in range(len(env.env.search.world.boxes)) for t in env.env.detector.tracks_of((k,)) if t in seen
            ]
        env.close()


@pytest.mark.slow
def test_expectation_and_episodes_agree_in_the_mean(env: TwinSearchEnv) -> None:
    """The mean SPL with the true targets agrees with the mean that the twins expect, up to sampling error."""
    true = UcONSearchEnv(EPISODES, habit_level="retrieval")
    spl, expected = [], []
    for episode in range(len(EPISODES)):
        observation, info = true.reset(options={"episode": episode})
        over = not observation["action_mask"][1:].any()
        while not over:
            observation, _, terminated, truncated, info = true.step(by_gain_over_cost(observation))
            over = terminated or truncated
        spl.append(float(info["episode_metrics"]["spl"]))
        expected.append(searched(env, episode)[0])
    assert np.mean(expected) == pytest.approx(np.mean(spl), abs=2.5 * np.std(spl) / len(spl) ** 0.5)
    assert np.std(expected) < 0.75 * np.std(spl)


def test_what_lies_beyond_views_is_what_a_walk_there_and_on_would_reach(env: TwinSearchEnv) -> None:
    for episode in (0, 7):
        env.reset(options={"episode": episode})
        twins, view = env.twins, env._searcher.map.view  # type: ignore[union-attr]
        left = twins.p * twins.unseen
        for moves in (5, 20):
            here = float(twins.within([view], [moves])[0, 0])
            assert here == pytest.approx(left[twins.shortest <= moves].sum() / left.sum(), abs=1e-6)
        beyond, offered = env.beyond(), len(env._tokens.choices)  # type: ignore[union-attr]
        assert beyond.shape == (32, len(MOVES))
        assert not beyond[offered:].any()
        ways = moves_to(env._tokens.arrays["views"])[:offered]  # type: ignore[union-attr]
        # From a view k moves away, at least everything within k fewer moves from here can be reached.
        for row, far in zip(beyond[:offered], ways, strict=True):
            assert row[-1] >= float(twins.within([view], [int(MOVES[-1] - np.ceil(far))])[0, 0]) - 1e-6


def test_a_copy_goes_on_by_itself(env: TwinSearchEnv) -> None:
    env.reset(options={"episode": 3})
    left, copy = env.twins.left, deepcopy(env)
    earned, after, steps_left = copy.go_on(0, 40)
    assert earned > 0.0
    assert after < left
    assert 0.8 < steps_left < 1.0
    assert env.twins.left == left
    again = deepcopy(env).go_on(0, 40)
    assert again == (earned, after, steps_left)


def test_before_a_reset_there_are_none() -> None:
    with pytest.raises(EpisodeError, match=r"call reset\(\) first"):
        TwinSearchEnv(EPISODES).beyond()
    with pytest.raises(EpisodeError, match="before the first reset"):
        _ = TwinSearchEnv(EPISODES).twins
    with pytest.raises(EpisodeError, match="go_on before reset"):
        TwinSearchEnv(EPISODES).go_on(0, 10)
