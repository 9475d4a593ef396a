"""A walk on which the robot looks where it is least sure, above all about things that it has been asked for before."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.memory.place_model import Model
from ucon.memory.protocol import Info, Observation
from ucon.memory.sighting_log import SightingLog
from ucon.perception.belief.coverage import Coverage, CoverageWeights
from ucon.perception.belief.recalled import Recalled
from ucon.search.searcher import Searcher
from ucon.task.actions import Action

#: Share of the interest that is in remembered places; the rest is in any place that was not looked at lately.
IN_PLACES: Final = 0.7
#: The walk ends when no view is worth more than this.
_LEAST_GAIN: Final = 1e-6


class Patrol:
    """One walk."""

    def __init__(self, info: Info, recalled: Recalled) -> None:
        """Begin a walk.

        Args:
            info: info of its first frame, with the kept map; nothing is asked for.
            recalled: what is worth a look; see :func:`interest`.
        """
        self._searcher = Searcher({**info, "target": "", "recalled": recalled}, Coverage("", CoverageWeights()))

    def act(self, observation: Observation, info: Info) -> int:
        """Take in a frame, and return the next action.

        Args:
            observation: observation of the frame.
            info: info of the frame.
        """
        action = self._searcher.look(observation, info)
        if action is not None:
            return int(action)
        choice = self._searcher.decision().best
        if choice is None or choice.gain < _LEAST_GAIN:
            return int(Action.DONE)
        return int(self._searcher.choose(choice))


def interest(
    log: SightingLog, model: Model, time: int, asked: Mapping[str, int], looked: NDArray[np.float64],
    left: NDArray[np.float64],
) -> Recalled:  # fmt: skip
    """What is worth a look: places where the robot is unsure about a thing, above all about things asked for.

    Args:
        log: what was seen.
        model: says where things are.
        time: time of the walk.
        asked: how often each thing was asked for.
        looked: (m, 4) points that were looked at before; see :class:`ucon.perception.belief.recalled.Recalled`.
        left: (m,) how much another look at each point is worth, 0 to 1.
    """
    worth = [np.zeros(0)]
    for name, thing in log.things.items():
        p = model.now(thing, time)
        worth.append((1.0 + asked.get(name, 0)) * p * (1.0 - p))
    xyz = np.concatenate([np.zeros((0, 3)), *(thing.places for thing in log.things.values())])
    spots = [spot for thing in log.things.values() for spot in thing.spots]
    value = np.concatenate(worth)
    return Recalled(xyz, IN_PLACES * value / max(float(value.sum()), 1e-9), spots, looked, left)
