"""Agents that choose waypoints do not stand still: turning on the spot shows nothing new after four turns."""

from __future__ import annotations

import re

import pytest

from models.agents.waypoint import WaypointAgent
from tests.models.playing import HONEST, config_of
from ucon.configuration.wiring import Factory
from ucon.envs.ucon_env import UcONEnv
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

WAYPOINT = [name for name in HONEST if isinstance(Factory(config_of(name)["agent"])(), WaypointAgent)]


def played(name: str, episode: Episode, *changes: str) -> tuple[str, dict]:
    """The actions of one episode, and its figures at the end."""
    config = config_of(name, *changes)
    agent = Factory(config["agent"])()
    env = UcONEnv([episode], habit_level="retrieval", observe=config["env"]["observe"], detector=True)
    obs, info = env.reset(options={"episode": 0})
    agent.reset([info])
    actions, over = "", False
    while not over:
        actions += str(agent.act([obs], [info])[0])
        obs, _, done, truncated, info = env.step(int(actions[-1]))
        over = done or truncated
    return actions, info["episode_metrics"]


@pytest.mark.parametrize("name", WAYPOINT)
def test_nobody_turns_on_the_spot_for_long(name):
    for episode in load_episodes("val")[40:43]:
        actions, _ = played(name, episode)
        assert not re.search("2{13}|1{13}", actions), actions


#: Episodes of ``val`` in which an agent once stood still to the end: in one, it saw a sliver of the target from afar
#: with no node in reach of it; in the other, a frontier was at the very node from which the agent looked into it.
STOOD_STILL = [
    ("val/val_category/seen_scene/033", "frontier_nearest", ()),
    ("val/val_category/val_scene/046", "l3mvn", ("agent.sure=0.2", "agent.possible=0.15")),
]


@pytest.mark.parametrize(("episode", "name", "changes"), STOOD_STILL)
def test_what_stood_still_goes_on(episode, name, changes):
    (chosen,) = [e for e in load_episodes("val") if e.id == episode]
    actions, metrics = played(name, chosen, *changes)
    assert not re.search("2{13}|1{13}", actions)
    assert metrics["success"]
