"""Searching by waypoints: what may be chosen (strategies), how a choice is carried out (explorer), the environment."""

from ucon.envs.waypoint.explorer import Decision, Explorer, Manner
from ucon.envs.waypoint.strategies import STRATEGIES, FineFrontiers, Frontiers, Landmarks, Strategy, Views

__all__ = [
    "STRATEGIES",
    "Decision",
    "Explorer",
    "FineFrontiers",
    "Frontiers",
    "Landmarks",
    "Manner",
    "Strategy",
    "Views",
]
