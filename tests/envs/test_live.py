"""``world="live"``: stepping PyBullet gives the same records as the compiled home."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from models.agents.belief import BeliefAgent
from models.agents.oracle import OracleAgent
from models.agents.random import RandomAgent
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.record import to_lines
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.sim.cache import load_house
from ucon.sim.live import LiveState
from ucon.sim.state import SceneState
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

AGENTS = {
    "oracle": (OracleAgent, {"privileged": True}),
    "random": (partial(RandomAgent, seed=2, done_probability=0.01), {}),
    "belief": (BeliefAgent, {}),
}


def small_episodes(count: int) -> tuple[Episode, ...]:
    """Episodes of the mini set in the smallest homes, half of them with a target in a closed container."""
    ranked = sorted(load_episodes("mini"), key=lambda e: (int(load_house(e.scene).grid.free.sum()), e.id))
    hidden = [e for e in ranked if "5" in e.solution][: count // 2]
    return (*hidden, *[e for e in ranked if "5" not in e.solution][: count - len(hidden)])


def records(episodes: tuple[Episode, ...], agent: str, world: str, task: str = "paper") -> Any:
    make, options = AGENTS[agent]
    env = partial(UcONEnv, episodes[:1], observe="symbolic", detector=True, world=world, task=task, **options)
    return to_lines(p.record for p in evaluate(RunSpec(make, env, "retrieval"), episodes, workers=0))


@pytest.mark.parametrize("agent", AGENTS)
def test_live_and_compiled_give_the_same_records(agent: str) -> None:
    episodes = small_episodes(4)
    assert any("5" in e.solution for e in episodes)
    assert records(episodes, agent, "live") == records(episodes, agent, "compiled")


def test_live_and_compiled_agree_on_the_released_rules() -> None:
    episodes = small_episodes(2)
    assert records(episodes, "random", "live", "released_code") == records(
        episodes, "random", "compiled", "released_code"
    )


def states_agree(episode: Episode) -> None:
    house = load_house(episode.scene)
    compiled, live = SceneState(house, episode.arrangement), LiveState(house, episode.arrangement)
    try:
        assert (live.free == compiled.free).all()
        assert (live.openable == compiled.openable).all()
        there = ~compiled.removed & (live.boxes != 0).any(axis=1)
        assert there.sum() > 20
        assert np.abs(live.boxes[there] - compiled.boxes[there]).max() < 1e-6
    finally:
        live.close()


@pytest.mark.parametrize("number", range(4))
def test_floor_boxes_and_joints_agree(number: int) -> None:
    states_agree(small_episodes(4)[number])


@pytest.mark.slow
@pytest.mark.parametrize("number", range(50))
def test_every_mini_episode_agrees(number: int) -> None:
    episode = load_episodes("mini")[number]
    states_agree(episode)
    for agent in ("oracle", "random"):
        assert records((episode,), agent, "live") == records((episode,), agent, "compiled")
