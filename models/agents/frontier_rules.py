"""``frontier_nearest``, ``frontier_utility``, ``frontier_weighted``: frontiers by geometry alone, as controls.

The edge of what is known is most of what map-based agents go by; an agent that asks a language model is worth its
calls only where it beats these. They use no habits, open what is closed where they arrive, and look around there.
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
    """Goes to the nearest frontier, to that of greatest utility (L3MVN's), or to the largest for its cost."""

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
        """Describe the agent.

        Args:
            rule: ``nearest`` by actions; ``utility``: the first on L3MVN's 5 cm map; ``weighted``: most cells of the
                edge for each action, ``overhead`` of which every look costs.
            overhead: actions.
            look_around: turn through four headings at the start and on arrival.
            replan_steps: actions after which a new choice is due; 0: on arrival only.
            opens: Open on arrival.
            seed: of the places drawn where there is no frontier.

        Raises:
            ConfigError: an unknown rule.
        """
        if rule not in RULES:
            raise ConfigError(unknown_name("frontier rule", rule, RULES))
        super().__init__(Manner(look_around=look_around, opens=opens, replan_steps=replan_steps), seed)
        self._rule, self._overhead = rule, overhead
        self.name = f"frontier_{rule}"

    def strategy(self, info: Info) -> Strategy:
        """See :class:`models.agents.waypoint.WaypointAgent`."""
        return FineFrontiers(Body.of(info)) if self._rule == "utility" else Frontiers()

    def choose(self, decisions: Sequence[Decision], slots: Sequence[int]) -> list[Chosen]:
        """See :class:`models.agents.waypoint.WaypointAgent`; of equals the first."""
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
