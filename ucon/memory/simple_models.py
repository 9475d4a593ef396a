"""Baseline memory models: a thing is where it was last seen, or where it was seen most often."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.memory.place_model import probability
from ucon.memory.sighting_log import SeenThing


class _Simple(Shared):
    """A baseline that ignores the calendar, places that were empty, and changes of habits."""

    uses_habits = False

    def __init__(self, trust: float = 0.9) -> None:
        """Choose the trust.

        Args:
            trust: probability that a thing is where the baseline says.

        Raises:
            ConfigError: ``trust`` is not a probability.
        """
        self._trust = probability("trust", trust)

    def begin(self, first_weekday: int) -> None:
        """Do nothing, since the calendar is ignored."""

    def left(self, when: NDArray[np.int64], seen: int, time: int) -> NDArray[np.float64]:
        """All 1: places that were empty are not remembered."""
        return np.ones(len(when))

    def first(self, thing: SeenThing, time: int) -> int:
        """0: all sightings count."""
        return 0

    def valid(self, thing: SeenThing, time: int, told: Collection[int], days: Sequence[int]) -> NDArray[np.float64]:
        """All 1: all habits are believed."""
        return np.ones(len(days))


class LastSeen(_Simple):
    """A thing is where it was last seen; once it is found missing there, nothing is known."""

    name = "last seen"

    def now(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> NDArray[np.float64]:
        """See :meth:`ucon.memory.place_model.PlaceModel.now`."""
        p = np.zeros(len(thing.places))
        if thing.seen:
            when, place = thing.seen[-1]
            if not any(empty == place and then > when for then, empty in thing.absent):
                p[place] = self._trust
        return p


class MostSeen(_Simple):
    """A histogram of the places where a thing was seen, whatever the time."""

    name = "most seen"

    def now(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> NDArray[np.float64]:
        """See :meth:`ucon.memory.place_model.PlaceModel.now`."""
        count = np.bincount([place for _, place in thing.seen], minlength=len(thing.places)).astype(np.float64)
        return self._trust * count / max(float(count.sum()), 1.0)
