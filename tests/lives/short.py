"""Shortened lives of the mini set, so that tests play only a few requests."""

from __future__ import annotations

from dataclasses import replace

from ucon.lives.clock import N_SLOTS
from ucon.lives.life import Life
from ucon.lives.sets import load_lives

#: Lives of the mini set in small homes; habits change in both.
SMALL = (1, 3)


def short_life(number: int = SMALL[0], requests: int = 6, days: int = 2) -> Life:
    """The first requests of a life of the mini set.

    Args:
        number: number of the life.
        requests: number of requests.
        days: days of the short life; if habits change, they do so on the last day.
    """
    life = load_lives("lives_mini")[number]
    return replace(
        life,
        days=days,
        change_day=None if life.change_day is None else days - 1,
        requests=life.requests[:requests],
        moves=tuple(move for move in life.moves if move.time < N_SLOTS * days),
        occasions=tuple(occasion for occasion in life.occasions if occasion[0] < days),
    )
