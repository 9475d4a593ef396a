"""``belief``: reads the habits once, keeps a belief over the target's place, and searches by probability over cost.

The reader gives the probability of each category as the target's anchor, with the relation. An anchor's probability is
divided among its instances seen so far; the rest stays in unexplored space. Where a frame shows no target, belief falls
by the chance that the frame would have shown one. A uniform part makes the search fall back to coverage once all places
named by the habits have been searched.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from models.agents.base import Controller, ControllerAgent
from models.agents.judging import judge_of
from models.agents.search import SearchController
from ucon.core.errors import ConfigError
from ucon.core.fingerprint import fingerprint_of
from ucon.perception.belief.coverage import CoverageWeights
from ucon.perception.belief.from_habits import Locate, ReadHabits, expecting
from ucon.perception.belief.target_belief import KNOWN_HOME, BeliefWeights
from ucon.perception.views.viewpoints import Costs
from ucon.task.agent import Info


class BeliefAgent(ControllerAgent):
    """Searches the places that the habits name, by probability over cost."""

    name = "belief"

    def __init__(
        self,
        locate: Locate | None = None,
        weights: BeliefWeights | None = None,
        coverage: CoverageWeights | None = None,
        costs: Costs | None = None,
        *,
        tour: bool = False,
        judge: str | None = "shipped",
    ) -> None:
        """Set up the agent.

        Args:
            locate: gives the distribution over places; by default it is read from the habits.
            weights: how belief becomes expected gain.
            coverage: gain of exploring, without any belief.
            costs: of moves, turns and looks, in actions.
            tour: True: the agent gets a map of the home from a walk before the target was placed. Privileged; it
                measures what knowing the map is worth.
            judge: of suspects, where the detector errs: ``shipped``, a folder, or None for the arithmetic posterior.
        """
        super().__init__()
        self.judge = judge_of(judge)
        self.locate = locate or ReadHabits()
        self._weights = weights or (KNOWN_HOME if tour else BeliefWeights())
        self._coverage = coverage or CoverageWeights()
        self._costs = costs or Costs()
        self._tour = tour
        if tour:
            self.name = f"{self.name} (knows the home)"

    def fingerprint(self) -> str:
        """Hash of the trained reader's weights; see :mod:`ucon.evaluation.playing.needed_weights`."""
        return str(fingerprint_of(self.locate))

    def start(self, info: Info) -> Controller:
        """A controller with the belief that the habits in ``info`` give.

        Raises:
            ConfigError: ``tour`` in an environment that is not privileged.
        """
        believing = expecting(info, self.locate, self._coverage, self._weights)
        controller = SearchController(info, believing, self._costs, self.judge)
        if self._tour:
            controller.searcher.map.tour(tour_of(info))
        return controller


def tour_of(info: Info) -> Iterable[tuple[dict[str, Any], dict[str, Any]]]:
    """Frames of a walk through the home, from the privileged ``info``: (observation, info) pairs.

    Raises:
        ConfigError: the environment is not privileged.
    """
    try:
        frames: Iterable[tuple[dict[str, Any], dict[str, Any]]] = info["privileged"]["tour"]()
    except KeyError:
        raise ConfigError("agent.tour=true needs the home: make the environment with privileged=True") from None
    return frames
