"""Where a thing is now, from where it was seen: people use it now and then and put it by their habits.

In every slot the thing is used with some probability and then put somewhere, independently of where it was. So it is
where it was last seen unless it was used since, and otherwise where it is usually put. A place that a later look showed
empty can hold it only by a use after that look. How it is usually put is learned by counts: a sighting counts for the
context in which it was made, and less for others; old ones fade, since habits change.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.core.sharing import Shared
from ucon.lives.clock import day_and_slot, is_weekend, weekday_of
from ucon.memory.sighting_log import SeenThing

#: Slots back over which uses are summed; older ones count as one.
_HORIZON = 60


@dataclass(frozen=True)
class PlaceWeights(Shared):
    """Numbers of the place model.

    Fitted on every second life of ``lives_val`` (498 requests for things seen before, searched by ``belief``): the mean
    log-likelihood of the true place is -1.03; by last places it is -1.75, by the most frequent ones -1.47.
    """

    use: float = 0.25
    """Probability that a thing is used, and put anew, in a slot."""
    doubt: float = 1.0
    """Weight of the told habits and of common sense, as a number of sightings."""
    other_slot: float = 0.6
    """What a sighting in another slot of the day counts."""
    other_days: float = 0.7
    """What a sighting on a workday counts for weekends, and the other way round."""
    fade: float = 0.98
    """What a sighting counts after a day."""

    def __post_init__(self) -> None:
        for name in ("use", "other_slot", "other_days", "fade"):
            probability(name, getattr(self, name))
        if not 0.0 <= self.doubt < math.inf:
            raise ConfigError(f"memory: doubt={brief(self.doubt)}, expected a number from 0 up")


def probability(name: str, value: float) -> float:
    """The value itself.

    Raises:
        ConfigError: it is not between 0 and 1; names the option.
    """
    if not 0.0 <= value <= 1.0:
        raise ConfigError(f"memory: {name}={brief(value)}, expected 0 to 1")
    return value


class Model(Protocol):
    """Says where a thing is, from what was seen of it."""

    name: str
    """Name in tables."""

    def begin(self, first_weekday: int) -> None:
        """Begin a life; see :meth:`PlaceModel.begin`."""
        ...

    def now(self, thing: SeenThing, time: int) -> NDArray[np.float64]:
        """Probability (n,) of each known place; see :meth:`PlaceModel.now`."""
        ...


class PlaceModel:
    """The probability of each known place of a thing."""

    name = "sightings"

    def __init__(self, weights: PlaceWeights | None = None) -> None:
        """Choose weights.

        Args:
            weights: numbers; fitted ones by default.
        """
        self.weights, self._first = weights or PlaceWeights(), 0

    def begin(self, first_weekday: int) -> None:
        """Begin a life.

        Args:
            first_weekday: of day 0: 0 (Monday) to 6.
        """
        self._first = first_weekday

    def now(self, thing: SeenThing, time: int) -> NDArray[np.float64]:
        """Probability (n,) that a thing is at each of its n known places at a time; the rest is elsewhere.

        Args:
            thing: what is known of it.
            time: of the request.
        """
        n = len(thing.places)
        if not thing.seen:
            return np.zeros(n)
        w = self.weights
        last, at = thing.seen[-1]
        empty = np.full(n, last)  # a use after this time may have put it to a place
        for when, place in thing.absent:
            empty[place] = max(empty[place], when)
        # By the last use in each slot since it was seen: elsewhere is column n.
        usual = np.zeros((n + 1,))
        slots = np.arange(last + 1, time + 1)[-_HORIZON:]
        chance = w.use * (1.0 - w.use) ** (time - slots)
        for slot, p in zip(slots.tolist(), chance.tolist(), strict=True):
            put = self.put(thing, slot)
            put[:n][slot <= empty] = 0.0
            usual += p * put
        stays = (1.0 - w.use) ** (time - last)
        if empty[at] == last:
            usual[at] += stays
        total = float(usual.sum())
        return usual[:n] / total if total > 0.0 else np.zeros(n)

    def put(self, thing: SeenThing, time: int) -> NDArray[np.float64]:
        """Where a thing is put that is used at a time: (n + 1,) probability of its known places, and of all others.

        Args:
            thing: what is known of it.
            time: of the use.
        """
        w, count = self.weights, np.zeros(len(thing.places) + 1)
        count[-1] = w.doubt
        for k, (when, place) in enumerate(thing.seen):
            count[place] += self._alike(when, time) * self._fresh(thing.seen, k)
        return count / count.sum()

    def _alike(self, seen: int, time: int) -> float:
        """What a sighting counts for another time."""
        w, (day, slot), (now, slot_now) = self.weights, day_and_slot(seen), day_and_slot(time)
        value = w.fade ** max(now - day, 0)
        if slot != slot_now:
            value *= w.other_slot
        if is_weekend(weekday_of(day, self._first)) != is_weekend(weekday_of(now, self._first)):
            value *= w.other_days
        return float(value)

    def _fresh(self, seen: Sequence[tuple[int, int]], k: int) -> float:
        """What a sighting adds to the one before: at the same place it may be that nobody used the thing since."""
        if k == 0 or seen[k - 1][1] != seen[k][1]:
            return 1.0
        return float(1.0 - (1.0 - self.weights.use) ** (seen[k][0] - seen[k - 1][0]))
