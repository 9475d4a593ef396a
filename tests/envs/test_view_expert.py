"""The expert that knows the home: what it makes of views, and that nobody else learns of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from ucon.core.errors import ConfigError
from ucon.envs.ucon_env import UcONEnv
from ucon.envs.waypoint.search_env import UcONSearchEnv
from ucon.envs.waypoint.view_expert import NOTHING, ViewExpert
from ucon.habits.types import RELATIONS
from ucon.perception.belief import Locations
from ucon.perception.reading import ReadHabits
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes


@pytest.fixture(scope="module")
def episodes() -> tuple[Episode, ...]:
    return load_episodes("mini")


def test_nobody_but_the_trainer_learns_of_it(episodes: tuple[Episode, ...]) -> None:
    env, plain = UcONSearchEnv(episodes, expert=True), UcONSearchEnv(episodes)
    for number in range(0, len(episodes), 5):
        (obs, told), (unaware, said) = (e.reset(options={"episode": number}) for e in (env, plain))
        for _ in range(4):
            assert set(obs) - set(unaware) == {"expert"}
            assert all(np.array_equal(obs[name], unaware[name]) for name in unaware)
            assert set(told) == set(said)
            assert "privileged" not in told
            assert obs in env.observation_space
            views = obs["action_mask"] > 0
            assert (obs["expert"][~views] == NOTHING).all()
            (obs, _, *over, told), (unaware, *_, said) = env.step(0), plain.step(0)
            if any(over):
                break


def test_who_knows_home_and_place_points_there(episodes: tuple[Episode, ...]) -> None:
    """Told by which thing the target is, of which there is one: the view that it likes best leads to the target."""

    def locate(info: Mapping[str, Any]) -> Locations:
        placed = env.env.episode.target_object
        p = np.zeros((1, len(RELATIONS)))
        p[0, RELATIONS.index(placed.relation)] = 1.0
        return Locations((env.env.search.world.categories[placed.anchor],), p)

    env, nearer = UcONSearchEnv(episodes, expert=True, to_go=True, locate=locate), []
    for number in range(0, len(episodes), 3):
        obs, _ = env.reset(options={"episode": number})
        names = env.env.search.world.categories
        only = names.count(names[env.env.episode.target_object.anchor]) == 1
        for _ in range(12 if only else 0):
            if (obs["expert"] > NOTHING).any():
                best = int(obs["expert"].argmax())
                assert obs["action_mask"][best]
                nearer.append(bool(obs["to_go"][best] < obs["to_go"][-1]))
            obs, _, terminated, truncated, _ = env.step(int(obs["prior"].argmax()))
            if terminated or truncated:
                break
    assert len(nearer) > 30
    assert np.mean(nearer) > 0.85


def test_it_needs_the_home(episodes: tuple[Episode, ...]) -> None:
    env = UcONEnv(episodes, detector=True)
    _, info = env.reset(options={"episode": 0})
    locate = ReadHabits()
    with pytest.raises(ConfigError, match="privileged=True"):
        ViewExpert(env, locate, 0.1).begin(episodes[0], "none", locate(info))
