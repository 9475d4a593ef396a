"""Where and when the robot last saw each possession. Privileged: for records, not for agents."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.lives.clock import N_SLOTS, day_and_slot
from ucon.lives.request_record import LifeFacts
from ucon.lives.timeline import Timeline
from ucon.task.rules import TaskRules


class LastSeen:
    """Tracks what the robot sees in one life."""

    def __init__(self, timeline: Timeline) -> None:
        """Start with nothing seen."""
        self._timeline = timeline
        count = len(timeline.life.possessions)
        self._time, self._place = np.full(count, -1), np.full(count, -1)

    def look(self, counts: NDArray[np.int32], time: int, rules: TaskRules) -> None:
        """Note what is in view.

        Args:
            counts: (n,) pixels of every instance in the canonical view.
            time: time of the request.
            rules: say how many pixels of a thing are needed to count as seen.
        """
        first = len(counts) - len(self._time)
        seen = counts[first:] >= rules.done_min_pixels
        self._time[seen], self._place[seen] = time, self._timeline.at[time][seen]

    def last(self, possession: int) -> tuple[int, int] | None:
        """Time and place at which a possession was last seen; None: never."""
        time, place = int(self._time[possession]), int(self._place[possession])
        return (time, place) if time >= 0 else None

    def facts(self, number: int, *, obeys: bool) -> LifeFacts:
        """The facts of a request before its first frame.

        Args:
            number: number of the request.
            obeys: whether a given sentence supports the place where the requested thing is.
        """
        life = self._timeline.life
        asked = life.requests[number]
        k, (day, slot) = asked.possession, day_and_slot(asked.time)
        ever = self._time[k] >= 0
        place = int(self._timeline.at[asked.time, k])
        changed = bool(life.change_day is not None and day >= life.change_day and life.possessions[k].later)
        return LifeFacts(
            life=life.id,
            request=number,
            day=day,
            slot=slot,
            seen_days_ago=round(float(asked.time - self._time[k]) / N_SLOTS, 6) if ever else None,
            moved=bool(place != self._place[k]) if ever else None,
            obeys=obeys,
            changed=changed,
        )
