"""``oracle_habits``: knows the household's exact habits, and where it last saw the thing.

Like any agent with a memory, it does not know what happened since.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from models.agents.base import Controller
from models.agents.belief import BeliefAgent
from ucon.core.errors import ConfigError
from ucon.evaluation.kept_memories import Truth
from ucon.habits.book import contexts_book
from ucon.lives.expected import expected_places
from ucon.objects.model import RELATIONS
from ucon.perception.belief.recalled import Recalled
from ucon.perception.belief.target_belief import Locations
from ucon.task.agent import Info

#: Probability that the thing is at one of the places that the rules give.
_SURE = 0.98


def expected(info: Info) -> tuple[Truth, int, NDArray[np.float64]]:
    """Truth of the life, number of the requested possession, and the probability of each of its places.

    Args:
        info: of a request's first frame in a privileged environment of lives.

    Raises:
        ConfigError: the environment is not privileged, or not one of lives.
    """
    try:
        life, number, seen = (info["privileged"][name] for name in ("life", "request", "last_seen"))
    except KeyError:
        raise ConfigError(
            "agent oracle_habits needs a life and its rules: task=resident, in an environment with privileged=True"
        ) from None
    asked = life.requests[number]
    p = expected_places(life, contexts_book(), asked.possession, asked.time, seen)
    return Truth.of(life), asked.possession, p


def expected_locations(info: Info) -> Locations:
    """Anchors and relations of the places where the target is expected.

    Args:
        info: of a request's first frame in a privileged environment of lives.
    """
    truth, possession, p = expected(info)
    names = tuple(dict.fromkeys(anchor for _, anchor in truth.spots[possession]))
    found = np.zeros((len(names), len(RELATIONS)))
    for (relation, anchor), value in zip(truth.spots[possession], p.tolist(), strict=True):
        found[names.index(anchor), RELATIONS.index(relation)] += value  # type: ignore[arg-type]
    return Locations(names, found)


class OracleHabitsAgent(BeliefAgent):
    """An upper bound of reading habits and remembering, without seeing what happens between requests."""

    name = "oracle_habits"
    uses_habits = False

    def __init__(self, *, points: bool = True, judge: str | None = "shipped") -> None:
        """Set up the agent.

        Args:
            points: True: it knows the exact points of the places. False: only their anchors and relations, like an
                agent that reads habits without errors, and the points that its memory holds.
            judge: of suspects; see :class:`models.agents.belief.BeliefAgent`.
        """
        super().__init__(expected_locations, judge=judge)
        self._points = points

    def start(self, info: Info) -> Controller:
        """A controller that is given the places by the rules: anchors, and points once these are mapped."""
        if not self._points:
            return super().start(info)
        truth, possession, p = expected(info)
        spots = [(spot,) for spot in truth.spots[possession]]
        return super().start({**info, "recalled": Recalled(truth.xyz[possession], _SURE * p, spots)})
