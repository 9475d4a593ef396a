"""Search: which candidates an agent may choose from, how a choice is carried out, and search by gain over cost.

Strategies list candidates, and the explorer carries out choices among them; the searcher values all views instead.
"""

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
