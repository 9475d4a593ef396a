"""``oracle_locations``: is given the true distribution of the target's places, and searches like ``belief``."""

from __future__ import annotations

import numpy as np

from models.agents.belief import BeliefAgent
from ucon.core.errors import ConfigError
from ucon.objects.model import RELATIONS
from ucon.perception.belief.target_belief import Locations
from ucon.task.agent import Info


def true_locations(info: Info) -> Locations:
    """The household's distribution over (anchor, relation), from which the episode was drawn.

    Args:
        info: of the reset of a privileged environment.

    Raises:
        ConfigError: the environment is not privileged.
    """
    try:
        places = info["privileged"]["locations"]
    except KeyError:
        raise ConfigError(
            "agent oracle_locations needs the household's places: make the environment with privileged=True"
        ) from None
    names = tuple(sorted({anchor for _, anchor, _ in places}))
    p = np.zeros((len(names), len(RELATIONS)))
    for relation, anchor, probability in places:
        p[names.index(anchor), RELATIONS.index(relation)] += probability
    return Locations(names, p)


class OracleLocationsAgent(BeliefAgent):
    """An upper bound of reading habits: knows the places a household uses, but not the map or which place is in use."""

    name = "oracle_locations"
    uses_habits = False

    def __init__(self, *, tour: bool = False, judge: str | None = "shipped") -> None:
        """Set up the agent.

        Args:
            tour: True: it also gets a map of the home beforehand; see :class:`models.agents.belief.BeliefAgent`.
            judge: of suspects; see there.
        """
        super().__init__(true_locations, tour=tour, judge=judge)
