"""``belief``: reads the habits once, spreads its belief over the things it sees, searches by probability over cost.

The reader says how probable each category is as the target's anchor, and by which relation. An anchor's share goes to
its instances seen so far, the rest waits in unexplored space. What a frame shows empty is lowered by the chance that
it would have shown the target; a flat tail makes the search fall back to coverage once the habits are spent.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from models.agents.base import Controller, ControllerAgent
from models.agents.search import SearchController
from ucon.core.errors import ConfigError
from ucon.core.fingerprint import fingerprint_of
from ucon.perception.belief.coverage import CoverageWeights
from ucon.perception.belief.from_habits import Locate, ReadHabits, expecting
from ucon.perception.belief.target_belief import KNOWN_HOME, BeliefWeights
from ucon.perception.views.viewpoints import Costs
from ucon.task.agent import Info


class BeliefAgent(ControllerAgent):
    """Searches by what the habits say."""

    name = "belief"

    def __init__(
        self,
        locate: Locate | None = None,
        weights: BeliefWeights | None = None,
        coverage: CoverageWeights | None = None,
        costs: Costs | None = None,
        *,
        tour: bool = False,
    ) -> None:
        """Describe the agent.

        Args:
            locate: gives the distribution over places; by default it is read from the habits.
            weights: how belief becomes expected mass.
            coverage: what is expected without any belief.
            costs: of moves, turns and looks.
            tour: it knows the home, as one who walked through it before the target was put there: privileged, to
                measure what knowing the map is worth.
        """
        super().__init__()
        self._locate = locate or ReadHabits()
        self._weights = weights or (KNOWN_HOME if tour else BeliefWeights())
        self._coverage = coverage or CoverageWeights()
        self._costs = costs or Costs()
        self._tour = tour
        if tour:
            self.name = f"{self.name} (knows the home)"

    def fingerprint(self) -> str:
        """Which trained reader says where the target may be, see :mod:`ucon.evaluation.playing.needed_weights`."""
        return str(fingerprint_of(self._locate))

    def start(self, info: Info) -> Controller:
        """See :class:`models.agents.base.ControllerAgent`."""
        believing = expecting(info, self._locate, self._coverage, self._weights)
        controller = SearchController(info, believing, self._costs)
        if self._tour:
            controller.searcher.map.tour(tour_of(info))
        return controller


def tour_of(info: Info) -> Iterable[tuple[dict[str, Any], dict[str, Any]]]:
    """Frames of a walk through the home.

    Raises:
        ConfigError: the environment tells nobody.
    """
    try:
        frames: Iterable[tuple[dict[str, Any], dict[str, Any]]] = info["privileged"]["tour"]()
    except KeyError:
        raise ConfigError("agent.tour=true needs the home: make the environment with privileged=True") from None
    return frames
