"""``oracle_now``: is given the target's current place, and walks there like ``belief``."""

from __future__ import annotations

import numpy as np

from models.agents.base import Controller
from models.agents.belief import BeliefAgent
from ucon.core.errors import ConfigError
from ucon.objects.model import RELATIONS
from ucon.perception.belief.recalled import Recalled
from ucon.perception.belief.target_belief import Locations
from ucon.sim.cache import load_house
from ucon.task.agent import Info
from ucon.task.episode import Episode


def true_location(info: Info) -> Locations:
    """The target's current anchor and relation.

    Args:
        info: of the reset of a privileged environment.

    Raises:
        ConfigError: the environment is not privileged.
    """
    episode = _episode(info)
    names = load_house(episode.scene).categories + tuple(placed.category for placed in episode.arrangement.objects)
    target = episode.target_object
    p = np.zeros((1, len(RELATIONS)))
    p[0, RELATIONS.index(target.relation)] = 1.0
    return Locations((names[target.anchor],), p)


def _episode(info: Info) -> Episode:
    try:
        episode: Episode = info["privileged"]["episode"]
    except KeyError:
        raise ConfigError(
            "agent oracle_now needs the target's place: make the environment with privileged=True"
        ) from None
    return episode


class OracleNowAgent(BeliefAgent):
    """An upper bound of remembering: knows the target's place, but of the home only what it has seen."""

    name = "oracle_now"
    uses_habits = False

    def __init__(self, *, judge: str | None = "shipped") -> None:
        """Set up the agent.

        Args:
            judge: of suspects; see :class:`models.agents.belief.BeliefAgent`.
        """
        super().__init__(true_location, judge=judge)

    def start(self, info: Info) -> Controller:
        """A controller that is given the place: its anchor, and once that part of the home is mapped, its point."""
        place = true_location(info)
        point = info["privileged"]["target_xyz"]
        how = RELATIONS[int(place.p[0].argmax())]
        recalled = Recalled(np.array([point]), np.array([0.98]), [((how, place.names[0]),)])
        return super().start({**info, "recalled": recalled})
