"""Gymnasium ids. ``import ucon.envs`` registers them; Gymnasium 1 looks for no plugins by itself."""

from __future__ import annotations

import gymnasium as gym


def register_envs() -> None:
    """Register all once; an episode ends itself after 300 steps, so no time limit is wrapped around it."""
    if "UcON-v0" not in gym.registry:
        gym.register(id="UcON-v0", entry_point="ucon.envs.ucon_env:UcONEnv")
    if "UcONSearch-v0" not in gym.registry:
        gym.register(id="UcONSearch-v0", entry_point="ucon.envs.search.env:UcONSearchEnv")
    if "UcONImageGoal-v0" not in gym.registry:
        gym.register(id="UcONImageGoal-v0", entry_point="ucon.envs.image_goal:UcONImageGoalEnv")
