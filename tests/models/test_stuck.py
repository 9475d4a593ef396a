"""Agents that choose waypoints do not stand still: turning on the spot shows nothing new after four turns."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import get_class
from omegaconf import OmegaConf

from models.agents.waypoint import WaypointAgent
from ucon.commands.wiring import Factory
from ucon.envs.ucon_env import UcONEnv
from ucon.task.sets import load_episodes

CONFIGS = Path(__file__).parents[2] / "configs"


def composed(name: str, *changes: str) -> dict:
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        config = compose("eval", [f"agent={name}", *changes])
    return OmegaConf.to_container(config, resolve=True)


WAYPOINT = [
    path.stem
    for path in sorted((CONFIGS / "agent").glob("*.yaml"))
    if issubclass(get_class(composed(path.stem)["agent"]["_target_"]), WaypointAgent)
]


def played(name: str, episode: object, *changes: str) -> tuple[str, dict]:
    """The actions of one episode, and how it ended."""
    config = composed(name, *changes)
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


#: Episodes of ``val`` in which an agent once stood still to the end: a sliver of the target seen from afar, with no
#: node in reach of it; a frontier at the very node that it was looked into from.
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
