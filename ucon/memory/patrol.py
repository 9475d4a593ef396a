"""A walk through the home on which the robot looks where it knows least: what was asked for before it asks itself."""

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

#: Part of the interest that is in the remembered places; the rest is anywhere that was not looked at lately.
IN_PLACES: Final = 0.7
#: The walk ends where no view is worth more.
_LEAST_GAIN: Final = 1e-6


class Patrol:
    """One walk."""

    def __init__(self, info: Info, recalled: Recalled) -> None:
        """Begin a walk.

        Args:
            info: of its first frame, with the kept map; nothing is asked for.
            recalled: what is worth a look; see :func:`interest`.
        """
        self._searcher = Searcher({**info, "target": "", "recalled": recalled}, Coverage("", CoverageWeights()))

    def act(self, observation: Observation, info: Info) -> int:
        """Take in a frame; the action that follows.

        Args:
            observation: of the frame.
            info: of the frame.
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
    """What is worth a look: places of which the robot is unsure, of things that are asked for.

    Args:
        log: what was seen.
        model: says where things are.
        time: of the walk.
        asked: how often each thing was asked for.
        looked: (m, 4) points that were looked at before; see :class:`ucon.perception.belief.recalled.Recalled`.
        left: (m,) what is worth another look there, 0 to 1.
    """
    worth = [np.zeros(0)]
    for name, thing in log.things.items():
        p = model.now(thing, time)
        worth.append((1.0 + asked.get(name, 0)) * p * (1.0 - p))
    xyz = np.concatenate([np.zeros((0, 3)), *(thing.places for thing in log.things.values())])
    spots = [spot for thing in log.things.values() for spot in thing.spots]
    value = np.concatenate(worth)
    return Recalled(xyz, IN_PLACES * value / max(float(value.sum()), 1e-9), spots, looked, left)
