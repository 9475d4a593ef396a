"""``frontier``: explores the nearest unknown space, looks at what it passes, opens closed containers.

Reads no habits.
"""

from __future__ import annotations

from models.agents.base import Controller, ControllerAgent
from models.agents.judging import judge_of
from models.agents.search import SearchController
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.views.viewpoints import Costs
from ucon.task.agent import Info


class FrontierAgent(ControllerAgent):
    """Searches by coverage: every place not yet seen is equally likely to hold the target."""

    name = "frontier"
    uses_habits = False

    def __init__(
        self, weights: CoverageWeights | None = None, costs: Costs | None = None, judge: str | None = "shipped"
    ) -> None:
        """Set up the agent.

        Args:
            weights: expected gain of unexplored space, surfaces and containers.
            costs: of moves, turns and looks, in actions.
            judge: of suspects, where the detector errs: ``shipped``, a folder, or None for the arithmetic posterior.
        """
        super().__init__()
        self.judge = judge_of(judge)
        self._weights = weights or CoverageWeights()
        self._costs = costs or Costs()

    def start(self, info: Info) -> Controller:
        """A controller that searches by coverage; only the target in ``info`` is used."""
        return SearchController(info, Coverage(str(info["target"]), self._weights), self._costs, self.judge)
