"""``frontier``: explores the nearest unknown, looks at what it passes, opens what is closed. Reads no habits."""

from __future__ import annotations

from models.agents.base import Controller, ControllerAgent
from models.agents.search import SearchController
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.views.viewpoints import Costs
from ucon.task.agent import Info


class FrontierAgent(ControllerAgent):
    """Searches by coverage alone."""

    name = "frontier"
    uses_habits = False

    def __init__(self, weights: CoverageWeights | None = None, costs: Costs | None = None) -> None:
        """What coverage expects, and what actions cost."""
        super().__init__()
        self._weights = weights or CoverageWeights()
        self._costs = costs or Costs()

    def start(self, info: Info) -> Controller:
        """See :class:`models.agents.base.ControllerAgent`."""
        return SearchController(info, Coverage(str(info["target"]), self._weights), self._costs)
