"""``oracle_locations``: knows all places where this household keeps the target, and searches like ``belief``."""

from __future__ import annotations

import numpy as np

from models.agents.belief import BeliefAgent
from ucon.core.errors import ConfigError
from ucon.objects.model import RELATIONS
from ucon.perception.belief.target_belief import Locations
from ucon.task.agent import Info


def true_locations(info: Info) -> Locations:
    """The household's own distribution over (anchor, relation), as the episode was drawn from it."""
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
    """What perfect reading would give: it knows neither the map, nor where anchors stand, nor which place it is now."""

    name = "oracle_locations"
    uses_habits = False

    def __init__(self, *, tour: bool = False) -> None:
        """It has nothing to read. ``tour``: it knows the map as well."""
        super().__init__(true_locations, tour=tour)
