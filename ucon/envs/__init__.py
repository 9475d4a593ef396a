"""Environments over the task: ``UcON-v0`` with seven actions."""

from ucon.envs.registration import register_envs

register_envs()
