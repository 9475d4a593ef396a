"""Baselines of remembering: where a thing was last seen, and where it was seen most often."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.memory.place_model import probability
from ucon.memory.sighting_log import SeenThing


class _Simple(Shared):
    """A baseline of memory: it ignores the calendar, places that were empty, and changes of habits."""

    uses_habits = False

    def __init__(self, trust: float = 0.9) -> None:
        """Choose the trust.

        Args:
            trust: probability that a thing is where the baseline says.

        Raises:
            ConfigError: it is no probability.
        """
        self._trust = probability("trust", trust)

    def begin(self, first_weekday: int) -> None:
        """Nothing depends on the calendar."""

    def left(self, when: NDArray[np.int64], seen: int, time: int) -> NDArray[np.float64]:
        """Of places elsewhere nothing is remembered: all is left."""
        return np.ones(len(when))

    def first(self, thing: SeenThing, time: int) -> int:
        """All sightings count."""
        return 0

    def valid(self, thing: SeenThing, time: int, told: Collection[int], days: Sequence[int]) -> NDArray[np.float64]:
        """All habits are believed."""
        return np.ones(len(days))


class LastSeen(_Simple):
    """A thing is where it was last seen; once that turns out wrong, nothing is known."""

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
    """A thing is where it was seen most often: a histogram of places, whatever the time."""

    name = "most seen"

    def now(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> NDArray[np.float64]:
        """See :meth:`ucon.memory.place_model.PlaceModel.now`."""
        count = np.bincount([place for _, place in thing.seen], minlength=len(thing.places)).astype(np.float64)
        return self._trust * count / max(float(count.sum()), 1.0)
