"""A tour of the home before the search: it shows the home, never the target, and changes nothing in the search."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from models.agents.belief import BeliefAgent
from models.agents.oracle_locations import OracleLocationsAgent
from ucon.core.errors import ConfigError
from ucon.envs.tour import STRIDE, stops
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.task.agent import Agent


def made(**options: Any) -> UcONEnv:
    return UcONEnv(
        "mini", observe="symbolic", **{"privileged": True, "detector": True, "habit_level": "none"} | options
    )


def played(env: UcONEnv, agent: Agent, number: int) -> dict[str, Any]:
    obs, info = env.reset(options={"episode": number})
    agent.reset([info])
    while "episode_metrics" not in info:
        obs, _, _, _, info = env.step(agent.act([obs], [info])[0])
    return dict(info["episode_metrics"])


def test_stops_are_a_metre_apart_where_one_can_walk() -> None:
    env = made()
    env.reset(options={"episode": 0})
    free, start = env.search.world.free, (env.search.pose.i, env.search.pose.j)
    found = stops(free, start)
    assert free[tuple(found.T)].all()
    assert start in {tuple(stop) for stop in found.tolist()}
    _, number = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    reached = np.argwhere(number == number[start])
    near = np.abs(reached[:, None] - found[None]).max(2).min(1)
    assert np.mean(near <= STRIDE) > 0.97


@pytest.mark.parametrize("number", range(0, 50, 10))
def test_a_tour_shows_the_home_but_not_the_target(number: int) -> None:
    env = made()
    _, info = env.reset(options={"episode": number})
    target, known = info["privileged"]["target_instance"], SemanticMap()
    known.tour(info["privileged"]["tour"]())
    assert env._detector is not None
    assert env._detector.tracks_of((target,)) == ()
    names = env.search.world.house.categories
    things = tuple(k for k, name in enumerate(names) if name not in {"floors", "walls", "ceilings"})
    tracks = env._detector.tracks_of(things)
    assert len(tracks) > 0.9 * len(things)
    assert np.mean([known.seen(track) for track in tracks]) > 0.99
    assert not known.views
    assert not known.visited.any()


def test_an_episode_goes_on_as_if_there_had_been_no_tour() -> None:
    env, actions = made(), [1, 0, 0, 2, 5, 3, 0, 0, 4, 1, 0, 0, 2, 6]
    seen: list[list[Any]] = []
    for toured in (False, True):
        _, info = env.reset(options={"episode": 7})
        if toured:
            for _ in info["privileged"]["tour"]():
                pass
        played = [env.step(action) for action in actions]
        seen.append([(obs["pose"].tolist(), obs["collision"], info["depth"].tobytes()) for obs, *_, info in played])
        seen[-1].append(played[-1][4]["episode_metrics"])
    assert seen[0] == seen[1]


def test_who_knows_home_and_places_finds_sooner() -> None:
    env = made()
    alone, guided = OracleLocationsAgent(), OracleLocationsAgent(tour=True)
    assert guided.name == "oracle_locations (knows the home)"
    spl = [[played(env, agent, number)["spl"] for number in range(0, 50, 4)] for agent in (alone, guided)]
    assert np.mean(spl[1]) > np.mean(spl[0]) + 0.03


def test_a_tour_is_told_to_privileged_agents_alone() -> None:
    _, info = made(privileged=False).reset(options={"episode": 0})
    assert "privileged" not in info
    with pytest.raises(ConfigError, match="privileged=True"):
        BeliefAgent(tour=True).reset([info])
    _, info = made(detector=None).reset(options={"episode": 0})
    with pytest.raises(ConfigError, match="detector=gt"):
        BeliefAgent(tour=True).reset([info])
