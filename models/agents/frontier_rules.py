"""``frontier_nearest``, ``frontier_utility``, ``frontier_weighted``: baselines that choose frontiers by geometry alone.

Much of what map-based agents achieve comes from frontiers; asking a language model is worth its calls only where it
beats these baselines. They read no habits, open closed containers where they arrive, and look around there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from models.agents.waypoint import Chosen, WaypointAgent
from ucon.core.errors import ConfigError, unknown_name
from ucon.perception.mapping.body import Body
from ucon.perception.views.candidates import Candidate
from ucon.search import Decision, FineFrontiers, Frontiers, Manner, Strategy
from ucon.task.agent import Info

Rule = Literal["nearest", "utility", "weighted"]
RULES = ("nearest", "utility", "weighted")


class FrontierRuleAgent(WaypointAgent):
    """Goes to the nearest frontier, to the one of highest utility (L3MVN's), or to the largest for its cost."""

    uses_habits = False

    def __init__(
        self,
        rule: Rule = "nearest",
        *,
        overhead: float = 4.0,
        look_around: bool = True,
        replan_steps: int = 0,
        opens: bool = True,
        seed: int = 0,
    ) -> None:
        """Set up the agent.

        Args:
            rule: ``nearest``: fewest actions; ``utility``: the first by L3MVN's utility on its 5 cm map; ``weighted``:
                most cells per action, where ``overhead`` is added to the actions.
            overhead: actions that every look costs in addition.
            look_around: turn through four headings at the start and on arrival.
            replan_steps: actions after which it chooses again; 0: only on arrival.
            opens: open a closed container on arrival.
            seed: of the random places that it goes to where there is no frontier.

        Raises:
            ConfigError: an unknown rule.
        """
        if rule not in RULES:
            raise ConfigError(unknown_name("frontier rule", rule, RULES))
        super().__init__(Manner(look_around=look_around, opens=opens, replan_steps=replan_steps), seed)
        self._rule, self._overhead = rule, overhead
        self.name = f"frontier_{rule}"

    def strategy(self, info: Info) -> Strategy:
        """Candidates of an episode: frontiers of the task's grid, or of L3MVN's 5 cm map for ``utility``."""
        return FineFrontiers(Body.of(info)) if self._rule == "utility" else Frontiers()

    def choose(self, decisions: Sequence[Decision], slots: Sequence[int]) -> list[Chosen]:
        """The candidate of highest value in each decision; the first among equals.

        Args:
            decisions: one for each slot where a choice is due.
            slots: of the decisions.
        """
        out = []
        for decision in decisions:
            values = [self._value(candidate) for candidate in decision.candidates]
            scores = tuple(round(value, 4) for value in values)
            out.append(Chosen(scores.index(max(scores)), scores=scores))
        return out

    def _value(self, candidate: Candidate) -> float:
        if self._rule == "nearest":
            return -float(candidate.cost)
        if self._rule == "utility":
            return candidate.utility
        return candidate.cells / (candidate.cost + self._overhead)
