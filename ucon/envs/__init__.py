"""The Gymnasium environments ``UcON-v0`` (seven actions), ``UcONSearch-v0`` (views) and ``UcONImageGoal-v0``."""

from ucon.envs.registration import register_envs

register_envs()
