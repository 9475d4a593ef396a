"""Configured agents on stored episodes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from ucon.configuration.wiring import Factory
from ucon.envs.ucon_env import UcONEnv
from ucon.language.models.encoder import EncoderModel
from ucon.task.agent import Agent
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


def config_of(agent: str, *overrides: str) -> dict[str, Any]:
    """The evaluation's configuration; an agent that shows images gets a model that accepts them."""
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        composed = compose("eval", [f"agent={agent}", "out=runs/test", *overrides])
    config: dict[str, Any] = OmegaConf.to_container(composed, resolve=True)  # type: ignore[assignment]
    if config["agent"].get("inputs") == "images":
        config["agent"]["language"]["_target_"] = f"{__name__}.{SeeingEncoder.__name__}"
    return config


class SeeingEncoder(EncoderModel):
    """The encoder in place of a model that sees: it is given the images, and answers by the labels."""

    sees_images = True


def built(name: str, level: str = "retrieval") -> tuple[Agent, UcONEnv]:
    """An agent as configured, and the environment that it plays in, with small images."""
    config = config_of(name, f"habit_level={level}")
    return Factory(config["agent"])(), Factory(config["env"] | {"width_px": 128, "height_px": 128})()


#: These need a person (played in tests/pages/serve/test_play.py) or a life (played in tests/lives).
_NOT_HERE = ("human", "oracle_habits")
_CONFIGURED = sorted(path.stem for path in (CONFIGS / "agent").glob("*.yaml") if path.stem not in _NOT_HERE)
#: Networks over the seven actions. They play only a few steps, since many take a tenth of a second per step.
POLICIES = [name for name in _CONFIGURED if config_of(name)["agent"]["_target_"].endswith(".PolicyAgent")]
#: Networks without shipped weights.
_UNTRAINED = [name for name in _CONFIGURED if config_of(name)["agent"].get("checkpoint", "") is None]
AGENTS = [name for name in _CONFIGURED if name not in _UNTRAINED]
#: Agents that get no privileged information.
HONEST = [name for name in AGENTS if not config_of(name)["env"]["privileged"]]


def episodes(n: int) -> list[Episode]:
    """The longest searches of the mini set."""
    return sorted(load_episodes("mini"), key=lambda e: -e.shortest_path_m)[:n]


def gone(episode: Episode) -> Episode:
    """The same episode with the target moved out of the home."""
    objects = list(episode.arrangement.objects)
    objects[episode.target] = replace(objects[episode.target], position=(0.0, 0.0, -50.0))
    return replace(episode, arrangement=replace(episode.arrangement, objects=tuple(objects)))


def play(agent: Agent, env: UcONEnv, episode: Episode, most: int = 300, unseen: bool = False) -> list[int]:
    """Play an episode and return its actions; with ``unseen``, only until the target comes into view."""
    obs, info = env.reset(options={"episode": episode})
    agent.reset([info])
    actions: list[int] = []
    while len(actions) < most and not (unseen and env.search.counts[env.search.target]):
        actions += agent.act([obs], [info])
        obs, _, done, truncated, info = env.step(actions[-1])
        if done or truncated:
            break
    return actions
