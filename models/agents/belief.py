"""``belief``: reads the habits once, spreads its belief over the things it sees, searches by probability over cost.

The reader says how probable each category is as the target's anchor, and by which relation. An anchor's share goes to
its instances seen so far, the rest waits in unexplored space. What a frame shows empty is lowered by the chance that
it would have shown the target; a flat tail makes the search fall back to coverage once the habits are spent.
"""

from __future__ import annotations

from models.agents.base import Controller, ControllerAgent, Info
from models.agents.search import SearchController
from ucon.perception.belief import BeliefWeights
from ucon.perception.coverage import CoverageWeights
from ucon.perception.reading import Locate, ReadHabits, expecting
from ucon.perception.viewpoints import Costs


class BeliefAgent(ControllerAgent):
    """Searches by what the habits say."""

    name = "belief"

    def __init__(
        self,
        locate: Locate | None = None,
        weights: BeliefWeights | None = None,
        coverage: CoverageWeights | None = None,
        costs: Costs | None = None,
    ) -> None:
        """``locate``: gives the distribution over places; by default it is read from the habits."""
        super().__init__()
        self._locate = locate or ReadHabits()
        self._weights = weights or BeliefWeights()
        self._coverage = coverage or CoverageWeights()
        self._costs = costs or Costs()

    def start(self, info: Info) -> Controller:
        """See :class:`models.agents.base.ControllerAgent`."""
        believing = expecting(info, self._locate, self._coverage, self._weights)
        return SearchController(info, believing, self._costs)
