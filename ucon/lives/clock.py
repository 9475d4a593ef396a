"""Days and slots of a life: morning, midday and evening.

A time of a life is one number: ``3 * day + slot``, counted from the morning of day 0.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

#: Slots of a day, with the hour of each.
SLOTS: Final = {"morning": 8, "midday": 13, "evening": 19}
SLOT_NAMES: Final = tuple(SLOTS)
HOURS: Final = tuple(SLOTS.values())
N_SLOTS: Final = len(SLOTS)
_WEEK = 7
_WEEKEND = 5


def time_of(day: int, slot: int) -> int:
    """The number of a slot: 0 is the morning of day 0.

    Args:
        day: from 0.
        slot: 0 to 2, see :data:`SLOTS`.
    """
    return N_SLOTS * day + slot


def day_and_slot(time: int) -> tuple[int, int]:
    """Day and slot of a time, see :func:`time_of`."""
    return divmod(time, N_SLOTS)


def weekday_of(day: int, first_weekday: int) -> int:
    """Weekday, 0 (Monday) to 6.

    Args:
        day: day of the life, from 0.
        first_weekday: weekday of day 0.
    """
    return (first_weekday + day) % _WEEK


def is_weekend(weekday: int) -> bool:
    """Whether a weekday is Saturday or Sunday."""
    return weekday >= _WEEKEND


def weekends(times: NDArray[np.int64], first_weekday: int) -> NDArray[np.bool_]:
    """Which times (see :func:`time_of`) are at a weekend.

    Args:
        times: times in an array of any shape.
        first_weekday: weekday of day 0.
    """
    return (first_weekday + times // N_SLOTS) % _WEEK >= _WEEKEND
