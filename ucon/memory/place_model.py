"""Where a thing is now, given where it was seen: people use it now and then and put it away by their habits.

In every slot the thing is used with some probability and then put somewhere, independently of where it was. So it is
where it was last seen unless it was used since, and otherwise where it is usually put. A place that a later look showed
empty can hold it only if it was used after that look. Where it is usually put is learned by counting: a sighting counts
fully for its own part of the day and week and less for others; sightings before a change of habits do not count.
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

#: Number of past slots over which uses are summed.
_HORIZON = 60
#: Least probability of a change point that is considered, and largest prior probability of a change.
_LEAST, _MOST_CHANGED = 1e-3, 0.9
#: Probability that the looks at a place during a request missed a thing there.
MISS = 0.05


@dataclass(frozen=True)
class PlaceWeights(Shared):
    """Numbers of the place model.

    Fitted on 24 lives of ``lives_train`` (:mod:`ucon.fitting.place_model`; 1,177 requests for things seen before,
    searched by ``belief``): the mean log-likelihood of the true place is -1.30. With last-seen places it is -2.25, with
    the most frequent places -1.66.
    """

    use: float = 0.3
    """Probability that a thing is used, and put somewhere again, in a slot."""
    doubt: float = 0.75
    """Weight of the given habits and of common sense, as a number of sightings."""
    other_slot: float = 0.6
    """Weight of a sighting in another slot of the day."""
    other_days: float = 0.55
    """Weight of a sighting on a workday for weekends, and the other way round."""
    change: float = 0.01
    """Probability that the habits of a thing change on a day."""
    news: float = 0.7
    """Probability that the habits of a thing changed on a day on which new ones were given."""
    mistakes: float = 0.02
    """Probability that people leave a thing anywhere by mistake."""

    def __post_init__(self) -> None:
        for name in ("use", "other_slot", "other_days", "change", "news", "mistakes"):
            probability(name, getattr(self, name))
        if not 0.0 < self.doubt < math.inf:  # 0 would give no prior for a thing not seen yet
            raise ConfigError(f"memory: doubt={brief(self.doubt)}, expected a number above 0")


def probability(name: str, value: float) -> float:
    """Check that a value is a probability, and return it.

    Raises:
        ConfigError: the value is not between 0 and 1; names the option.
    """
    if not 0.0 <= value <= 1.0:
        raise ConfigError(f"memory: {name}={brief(value)}, expected 0 to 1")
    return value


class Model(Protocol):
    """Predicts where a thing is, from its sightings."""

    name: str
    """Name in tables."""
    uses_habits: bool
    """Whether the model uses the days on which habits were given."""

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
        """Probability (H,) that habits have not changed since they were given; see :meth:`PlaceModel.valid`."""
        ...


class PlaceModel:
    """The probability of each known place of a thing."""

    name, uses_habits = "sightings", True

    def __init__(self, weights: PlaceWeights | None = None) -> None:
        """Choose weights.

        Args:
            weights: weights of the model; by default the fitted ones.
        """
        self.weights, self._first = weights or PlaceWeights(), 0

    def begin(self, first_weekday: int) -> None:
        """Begin a life.

        Args:
            first_weekday: weekday of day 0: 0 (Monday) to 6.
        """
        self._first = first_weekday

    def now(self, thing: SeenThing, time: int, told: Collection[int] = ()) -> NDArray[np.float64]:
        """Probability (n,) that a thing is at each of its n known places at a time; the rest is elsewhere.

        Args:
            thing: what is known about the thing.
            time: time of the request.
            told: days on which new habits of the thing were given.
        """
        n = len(thing.places)
        if not thing.seen:
            return np.zeros(n)
        w = self.weights
        last, at = thing.seen[-1]
        empty = np.full(n, last)  # only a use after this time can have put it at a place
        for when, place in thing.absent:
            empty[place] = max(empty[place], when)
        # Sum over the slot of the last use since it was seen; column n stands for elsewhere.
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
            when: (m,) slots of the last looks at these places; below 0 for none.
            seen: slot in which the thing was last seen anywhere; below 0 for never.
            time: time of the request.

        Returns:
            (m,) from :data:`MISS` to 1, relative to places that were not looked at since the thing was seen.
        """
        w = self.weights
        if seen >= time:
            return np.ones(len(when))
        whole = 1.0 if seen < 0 else 1.0 - (1.0 - w.use) ** (time - seen)
        since = 1.0 - (1.0 - w.use) ** (time - np.maximum(when, seen)).astype(np.float64)
        could = np.where(when <= seen, 1.0, since / max(whole, 1e-12))  # 0 if things are never used
        return MISS + (1.0 - MISS) * could

    def put(self, thing: SeenThing, slots: NDArray[np.int64], time: int, told: Collection[int] = ()) -> Array:
        """Where a thing is put after a use in some slots: (S, n + 1) probability of its known places, and elsewhere.

        Args:
            thing: what is known about the thing, which was seen at least once.
            slots: (S,) slots of the uses.
            time: current time.
            told: days on which new habits of the thing were given.
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
        """Probability (k + 1,), for c = 0 .. k, that the current habits began just before sighting c; 0: no change.

        Args:
            thing: what is known about the thing, which was seen k times, at least once.
            time: current time.
            told: days on which new habits of the thing were given.
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
        """Number of the sighting from which the current habits most probably hold; 0 if nothing changed."""
        return int(self.since(thing, time).argmax()) if thing.seen else 0

    def valid(self, thing: SeenThing, time: int, told: Collection[int], days: Sequence[int]) -> Array:
        """Probability (H,) that habits of a thing have not changed since they were given.

        Args:
            thing: what is known about the thing.
            time: current time.
            told: days on which new habits of the thing were given.
            days: day on which each of the H habits was given.
        """
        when = np.array(days, np.int64)
        # The sightings say nothing about news from before the thing was first seen.
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
        """Weight of sightings for other times; the arrays broadcast."""
        w = self.weights
        value = np.where(seen % N_SLOTS == time % N_SLOTS, 1.0, w.other_slot)
        alike = weekends(seen, self._first) == weekends(time, self._first)
        return np.asarray(value * np.where(alike, 1.0, w.other_days))

    def _fresh(self, seen: NDArray[np.int64], places: NDArray[np.int64]) -> Array:
        """Weight of each sighting; less at the same place as the one before, since the thing may not have been used."""
        again = np.concatenate([[False], places[1:] == places[:-1]])
        used = 1.0 - (1.0 - self.weights.use) ** np.diff(seen, prepend=0).astype(np.float64)
        return np.where(again, used, 1.0)


def _between(thing: SeenThing, time: int) -> list[tuple[int, int]]:
    """For each sighting, its day and that of the next sighting; the last pair ends at the current time."""
    return list(pairwise([when // N_SLOTS for when, _ in thing.seen] + [time // N_SLOTS]))
