"""Image goals: the agent gets the view from the goal, a reward for coming closer, and succeeds only there."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
import transformers
from gymnasium.utils.env_checker import check_env

import ucon.envs  # noqa: F401  (registers the environments)
from models.nets.vision.goals import ClipGoal, SentenceGoal
from models.zson import ZSON
from tests.learning.tiny_policy import TinyPolicy
from tests.learning.tiny_ppo import tiny_ppo
from tests.models.nets.tiny_models import clip
from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.image_goal import ImageGoalReward, UcONImageGoalEnv
from ucon.sim.paths import distances, path
from ucon.task.actions import Action

HEADINGS = {(1, 0): 0, (0, 1): 1, (-1, 0): 2, (0, -1): 3}


def turn(env: UcONImageGoalEnv, heading: int) -> list[tuple[Any, ...]]:
    steps = []
    while env.env.search.pose.heading != heading:
        steps.append(env.step(Action.ROTATE_LEFT))
    return steps


def walk(env: UcONImageGoalEnv) -> list[tuple[Any, ...]]:
    """Walk the shortest way to the goal and turn to the heading of its image."""
    goal, free, steps = (env.goal.i, env.goal.j), env.env.search.world.free, []
    here = env.env.search.pose
    nodes = path(distances(free, [goal]), (here.i, here.j))
    for (i, j), (k, m) in pairwise(nodes):
        steps += turn(env, HEADINGS[k - i, m - j])
        steps.append(env.step(Action.MOVE_AHEAD))
    return steps + turn(env, env.goal.heading)


@pytest.mark.parametrize("number", range(0, 50, 7))
def test_the_way_is_paid_and_ends_at_the_image(number: int) -> None:
    env = UcONImageGoalEnv("mini", reward=ImageGoalReward(step=0.0, turned=0.0))
    _, info = env.reset(options={"episode": number})
    whole_m = env._whole_m
    assert whole_m >= 2.0
    steps = walk(env)
    assert sum(step[1] for step in steps) == pytest.approx(whole_m)
    assert np.array_equal(steps[-1][0]["rgb"], info["goal_image"])
    _, reward, done, _, after = env.step(Action.DONE)
    assert done
    assert reward == 10.0
    assert after["episode_metrics"] == {"success": True, "spl": 1.0, "steps": len(steps) + 1}


def test_done_elsewhere_fails_and_turning_pays_near_the_goal() -> None:
    env = UcONImageGoalEnv("mini")
    env.reset(options={"episode": 0})
    _, reward, done, _, info = env.step(Action.DONE)
    assert done
    assert reward == pytest.approx(-0.01)
    assert info["episode_metrics"]["success"] is False
    env.reset(options={"episode": 0})
    walk(env)
    away, back = env.step(Action.ROTATE_LEFT)[1], env.step(Action.ROTATE_RIGHT)[1]
    assert away == pytest.approx(-0.01 - np.pi / 2)
    assert back == pytest.approx(-0.01 + np.pi / 2)
    env.step(Action.ROTATE_LEFT)
    assert env.step(Action.DONE)[1] == pytest.approx(4.99)  # there, but looking elsewhere


def test_running_out_of_steps_is_told() -> None:
    env = UcONImageGoalEnv("mini")
    env.reset(options={"episode": 3})
    for _ in range(299):
        assert "episode_metrics" not in env.step(Action.ROTATE_LEFT)[4]
    *_, truncated, info = env.step(Action.ROTATE_LEFT)
    assert truncated
    assert info["episode_metrics"] == {"success": False, "spl": 0.0, "steps": 300}


def test_goals_depend_on_the_episode_alone_and_are_no_targets() -> None:
    env, other = UcONImageGoalEnv("mini"), UcONImageGoalEnv("mini")
    goals = []
    for number in (4, 5, 4):
        _, info = env.reset(seed=number, options={"episode": number})
        goals.append((env.goal, info["goal_image"].tobytes()))
    _, info = other.reset(seed=9, options={"episode": 4})
    assert goals[0] == goals[2] == (other.goal, info["goal_image"].tobytes())
    assert goals[0] != goals[1]
    assert "privileged" not in info


def test_it_is_an_environment_of_gymnasium() -> None:
    check_env(gym.make("UcONImageGoal-v0").unwrapped, skip_render_check=True)
    with pytest.raises(ConfigError, match="observe=pixels"):
        UcONImageGoalEnv("mini", observe="symbolic")
    with pytest.raises(ConfigError, match="near_m"):
        UcONImageGoalEnv("mini", near_m=-1)
    with pytest.raises(EpisodeError, match="reset"):
        UcONImageGoalEnv("mini").step(0)


def both_towers(folder: Path) -> Path:
    """A tiny random CLIP with embeddings of 24 numbers, both towers and the tokenizer in one folder."""
    clip(folder, width=24)
    text = transformers.CLIPTextModelWithProjection.from_pretrained(folder).config
    vision = transformers.CLIPVisionConfig(
        hidden_size=32,
        intermediate_size=32,
        num_hidden_layers=1,
        num_attention_heads=2,
        image_size=32,
        patch_size=8,
        projection_dim=24,
    )
    torch.manual_seed(0)
    config = transformers.CLIPConfig(text_config=text.to_dict(), vision_config=vision.to_dict(), projection_dim=24)
    transformers.CLIPModel(config).save_pretrained(folder)
    return folder


def test_zson_looks_for_the_image_in_the_space_of_names(tmp_path: Path) -> None:
    zson = ZSON(ClipGoal(str(both_towers(tmp_path / "clip"))))
    env = UcONImageGoalEnv("mini")
    goals = []
    for number in (0, 1):
        _, info = env.reset(options={"episode": number})
        goals.append(zson.context(info)["goal"])
        named = zson.context({"target": info["target"]})["goal"]
        assert goals[-1].shape == named.shape == (24,)
        assert np.linalg.norm(goals[-1]) == pytest.approx(1.0, abs=1e-3)
        assert not np.allclose(goals[-1], named, atol=1e-2)
    assert not np.allclose(*goals, atol=1e-3)
    with pytest.raises(ConfigError, match="part=clip_goal agent"):
        ZSON(SentenceGoal()).context(info)


class GoalReader(TinyPolicy):
    """The tiny policy, given the brightness of the goal image instead of the number of habits."""

    reads_goal_images = True

    def context(self, info: Mapping[str, Any]) -> dict[str, np.ndarray]:
        return {"habits": np.array([info["goal_image"].mean() / 255], np.float32)}


def test_policies_that_read_images_learn_from_it(tmp_path: Path) -> None:
    env = functools.partial(UcONImageGoalEnv, "mini")
    learner = tiny_ppo(tmp_path, GoalReader(), env=env)
    figures = learner.step()
    assert np.isfinite(figures["loss"])
    assert abs(figures["return"]) > 0 or figures["episodes"] == 0
    learner.rollouts.close()
    with pytest.raises(ConfigError, match="TinyPolicy reads names, not images of goals"):
        tiny_ppo(tmp_path, TinyPolicy(), env=env)
