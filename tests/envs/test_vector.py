"""Gymnasium's vector environments, in one process and in several."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

import ucon.envs
from ucon.perception.mapping.nav import Nav
from ucon.perception.mapping.planner import Planner

assert ucon.envs  # registers the environments


@pytest.mark.parametrize("kind", ["sync", "async"])
@pytest.mark.parametrize(
    ("name", "options"),
    [("UcON-v0", {}), ("UcON-v0", {"habit_level": "full", "detector": True})],
    ids=["retrieval", "full"],
)
def test_homes_of_other_shapes_are_played_side_by_side(name: str, options: dict[str, object], kind: str) -> None:
    envs = gym.make_vec(name, num_envs=2, vectorization_mode=kind, texts=True, **options)
    try:
        _, infos = envs.reset(seed=0)
        navs = list(infos["nav"])
        assert all(isinstance(nav, Nav) for nav in navs)
        assert navs[0]["free"].shape != navs[1]["free"].shape, "two homes of one shape show nothing"
        assert len(set(infos["episode"])) == 2
        for k, nav in enumerate(navs):
            assert nav["free"][nav["start"]]
            assert len(infos["habit_rows"][k]) == len(infos["habits"][k])
            Planner(nav)
        for _ in range(3):
            observations, _, terminated, truncated, _ = envs.step(np.zeros(2, np.int64))
            assert observations["pose"].shape == (2, 4)
            assert not (terminated | truncated).any()
    finally:
        envs.close()


def test_a_grid_has_two_names() -> None:
    nav = Nav(np.ones((2, 3), bool), (1, 2))
    assert nav["start"] == (1, 2)
    assert nav["free"] is nav.free
    assert nav == Nav(np.ones((2, 3), bool), (1, 2))
    assert nav != Nav(np.ones((2, 3), bool), (1, 1))
    assert nav != Nav(np.zeros((2, 3), bool), (1, 2))
    with pytest.raises(KeyError, match="stop"):
        nav["stop"]
