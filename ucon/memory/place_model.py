"""Where a thing is now, from where it was seen: people use it now and then and put it by their habits.

In every slot the thing is used with some probability and then put somewhere, independently of where it was. So it is
where it was last seen unless it was used since, and otherwise where it is usually put. A place that a later look showed
empty can hold it only by a use after that look. How it is usually put is learned by counts: a sighting counts for the
context in which it was made, and less for others; those before a change of habits do not count.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError, brief
from ucon.core.sharing import Shared
from ucon.lives.clock import N_SLOTS, weekends
from ucon.memory.change_points import Array, change_posterior
from ucon.memory.sighting_log import SeenThing

#: Slots back over which uses are summed; older ones count as one.
_HORIZON = 60
#: Change points of less than this probability are left out; most that a change may be probable before anything is seen.
_LEAST, _MOST_CHANGED = 1e-3, 0.9
#: Probability that a request's looks at a place missed a thing there.
MISS = 0.05


@dataclass(frozen=True)
class PlaceWeights(Shared):
    """Numbers of the place model.

    Fitted on 24 lives of ``lives_train`` (:mod:`ucon.fitting.place_model`; 1,177 requests for things seen before,
    searched by ``belief``): the mean log-likelihood of the true place is -1.30; by last places it is -2.25, by the most
    frequent ones -1.66.
    """

    use: float = 0.3
    """Probability that a thing is used, and put anew, in a slot."""
    doubt: float = 0.75
    """Weight of the told habits and of common sense, as a number of sightings."""
    other_slot: float = 0.6
    """What a sighting in another slot of the day counts."""
    other_days: float = 0.55
    """What a sighting on a workday counts for weekends, and the other way round."""
    change: float = 0.01
    """Probability that the habits of a thing change on a day."""
    news: float = 0.7
    """Probability that they changed on a day on which new ones were told."""
    mistakes: float = 0.02
    """Probability that people leave a thing anywhere."""

    def __post_init__(self) -> None:
        for name in ("use", "other_slot", "other_days", "change", "news", "mistakes"):
            probability(name, getattr(self, name))
        if not 0.0 < self.doubt < math.inf:  # at 0 nothing would say where a thing is put that was not seen yet
            raise ConfigError(f"memory: doubt={brief(self.doubt)}, expected a number above 0")


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
    uses_habits: bool
    """Whether it makes something of the days on which habits were told."""

    def begin(self, first_weekday: int) -> None:
        """Begin a life; see :meth:`PlaceModel.begin`."""
        ...

    def now(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> NDArray[np.float64]:
        """Probability (n,) of each known place; see :meth:`PlaceModel.now`."""
        ...

    def left(self, when: NDArray[np.int64], seen: int, time: int) -> NDArray[np.float64]:
        """What is left (m,) of the probability of places that were empty; see :meth:`PlaceModel.left`."""
        ...

    def first(self, thing: SeenThing, time: int) -> int:
        """Number of the first sighting that still counts; see :meth:`PlaceModel.first`."""
        ...

    def valid(self, thing: SeenThing, time: int, told: Collection[int], days: Sequence[int]) -> Array:
        """Probability (H,) that habits have not changed since they were told; see :meth:`PlaceModel.valid`."""
        ...


class PlaceModel:
    """The probability of each known place of a thing."""

    name, uses_habits = "sightings", True

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

    def now(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> NDArray[np.float64]:
        """Probability (n,) that a thing is at each of its n known places at a time; the rest is elsewhere.

        Args:
            thing: what is known of it.
            time: of the request.
            told: days on which new habits of the thing were told.
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
        slots = np.arange(last + 1, time + 1)[-_HORIZON:]
        chance = w.use * (1.0 - w.use) ** (time - slots)
        put = self.put(thing, slots, time, told)
        put[:, :n][slots[:, None] <= empty] = 0.0
        usual = chance @ put
        stays = (1.0 - w.use) ** (time - last)
        if empty[at] == last:
            usual[at] += stays
        total = float(usual.sum())
        return usual[:n] / total if total > 0.0 else np.zeros(n)

    def left(self, when: NDArray[np.int64], seen: int, time: int) -> NDArray[np.float64]:
        """What is left of the probability of places that were empty: only a use since then can have put a thing there.

        Args:
            when: (m,) slots of the last looks at them; below 0 for none.
            seen: slot in which the thing was last seen anywhere; below 0 for never.
            time: of the request.

        Returns:
            (m,) from :data:`MISS` to 1, beside places that were not looked at since the thing was seen.
        """
        w = self.weights
        if seen >= time:
            return np.ones(len(when))
        whole = 1.0 if seen < 0 else 1.0 - (1.0 - w.use) ** (time - seen)
        since = 1.0 - (1.0 - w.use) ** (time - np.maximum(when, seen)).astype(np.float64)
        could = np.where(when <= seen, 1.0, since / max(whole, 1e-12))  # nothing is left where nobody uses things
        return MISS + (1.0 - MISS) * could

    def put(self, thing: SeenThing, slots: NDArray[np.int64], time: int, told: Collection[int] = ()) -> Array:
        """Where a thing is put that is used in some slots: (S, n + 1) probability of its known places, and of others.

        Args:
            thing: what is known of it, seen at least once.
            slots: (S,) of the uses.
            time: now.
            told: days on which new habits of the thing were told.
        """
        w, n = self.weights, len(thing.places)
        seen, places = np.array(thing.seen, np.int64).T
        counts = self._alike(seen[None], slots[:, None]) * self._fresh(seen, places)  # (S, k)
        at = np.eye(n + 1)[places]
        since = self.since(thing, time, told)
        found = np.zeros((len(slots), n + 1))
        for c in np.flatnonzero(since > _LEAST).tolist():
            one = counts[:, c:] @ at[c:]
            one[:, n] += w.doubt
            found += since[c] * one / one.sum(1, keepdims=True)
        return found / since[since > _LEAST].sum()

    def since(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> Array:
        """Probability (k + 1,) that the thing has been kept as now since before its sighting number c; 0: always.

        Args:
            thing: what is known of it, seen k times, at least once.
            time: now.
            told: days on which new habits of the thing were told.
        """
        w = self.weights
        seen, places = np.array(thing.seen, np.int64).T
        if w.change == 0.0 and not told:
            return np.eye(len(seen) + 1)[0]
        days = _between(thing, time)
        news = [any(before < day <= after for day in told) for before, after in days]
        changes = w.change * np.diff(np.array(days), axis=1)[:, 0] + float(w.news) * np.array(news)
        changes *= min(1.0, _MOST_CHANGED / max(float(changes.sum()), 1e-12))
        stays = (1.0 - w.use) ** np.diff(seen, prepend=-_HORIZON)
        counts = np.tril(self._alike(seen[None], seen[:, None]) * self._fresh(seen, places), -1)
        return change_posterior(places, stays, counts, changes, w.doubt, w.mistakes)

    def first(self, thing: SeenThing, time: int) -> int:
        """Number of the sighting since which the thing is most probably kept as now; 0 where nothing changed."""
        return int(self.since(thing, time).argmax()) if thing.seen else 0

    def valid(self, thing: SeenThing, time: int, told: Collection[int], days: Sequence[int]) -> Array:
        """Probability (H,) that habits of a thing have not changed since they were told.

        Args:
            thing: what is known of it.
            time: now.
            told: days on which new habits of the thing were told.
            days: on which each of the H habits was told.
        """
        when = np.array(days, np.int64)
        # Of news before it was first seen the sightings say nothing.
        first = thing.seen[0][0] // N_SLOTS if thing.seen else time // N_SLOTS
        before_all = max((day for day in told if day <= first), default=0)
        unseen = np.where(when < before_all, 1.0 - self.weights.news, 1.0)
        if not thing.seen:
            return unseen
        stale = np.zeros(len(when))
        for p, (before, after) in zip(self.since(thing, time, told)[1:], _between(thing, time), strict=True):
            changed = max((day for day in told if before < day <= after), default=after)
            stale += p * (when < changed)
        return np.asarray((1.0 - stale) * unseen)

    def _alike(self, seen: NDArray[np.int64], time: NDArray[np.int64]) -> Array:
        """What sightings count for other times; arrays that broadcast."""
        w = self.weights
        value = np.where(seen % N_SLOTS == time % N_SLOTS, 1.0, w.other_slot)
        alike = weekends(seen, self._first) == weekends(time, self._first)
        return np.asarray(value * np.where(alike, 1.0, w.other_days))

    def _fresh(self, seen: NDArray[np.int64], places: NDArray[np.int64]) -> Array:
        """What each sighting adds: at the same place as the one before it may be that nobody used the thing since."""
        again = np.concatenate([[False], places[1:] == places[:-1]])
        used = 1.0 - (1.0 - self.weights.use) ** np.diff(seen, prepend=0).astype(np.float64)
        return np.where(again, used, 1.0)


def _between(thing: SeenThing, time: int) -> list[tuple[int, int]]:
    """Days of each sighting and of the next one; the last pair ends now."""
    return list(pairwise([when // N_SLOTS for when, _ in thing.seen] + [time // N_SLOTS]))
