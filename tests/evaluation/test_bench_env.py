"""The benchmark counts the steps that are really played."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest

from ucon.core.rng import stream
from ucon.evaluation import bench_env
from ucon.task.sets import load_episodes


def test_every_step_of_every_choice_counts() -> None:
    episodes = load_episodes("mini")[:2]
    figures = bench_env._choices(episodes)
    choices, steps = 0, 0
    for number, episode in enumerate(episodes):
        env = gym.make("UcONSearch-v0", episodes=episodes)
        draw, ended = stream(0, "bench", "search", episode.id), False
        obs, _ = env.reset(seed=0, options={"episode": number})
        while not ended:
            action = int(draw.choice(np.flatnonzero(obs["action_mask"])))
            obs, _, terminated, truncated, info = env.step(action)
            choices, ended = choices + 1, terminated or truncated
        steps += info["episode_metrics"]["steps"]
    assert figures["search_steps_per_decision"] == pytest.approx(steps / choices)
