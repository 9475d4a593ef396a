"""Searching: what may be chosen (strategies), how it is carried out (explorer), views by gain over cost (searcher)."""

from ucon.search.explorer import Decision, Explorer, Manner
from ucon.search.strategies import STRATEGIES, FineFrontiers, Frontiers, Landmarks, Strategy, Views

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
