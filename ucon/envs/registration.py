"""Registers the Gymnasium ids. ``import ucon.envs`` calls it; Gymnasium 1 does not look for plugins."""

from __future__ import annotations

import gymnasium as gym


def register_envs() -> None:
    """Register the environments; calling it again does nothing.

    The environments end their episodes after 300 steps themselves, so no time limit is wrapped around them.
    """
    if "UcON-v0" not in gym.registry:
        gym.register(id="UcON-v0", entry_point="ucon.envs.ucon_env:UcONEnv")
    if "UcONResident-v0" not in gym.registry:
        gym.register(id="UcONResident-v0", entry_point="ucon.envs.resident:UcONResidentEnv")
    if "UcONSearch-v0" not in gym.registry:
        gym.register(id="UcONSearch-v0", entry_point="ucon.envs.search.env:UcONSearchEnv")
    if "UcONImageGoal-v0" not in gym.registry:
        gym.register(id="UcONImageGoal-v0", entry_point="ucon.envs.image_goal:UcONImageGoalEnv")
