"""Lives of the mini set cut short, so that tests play a few requests alone."""

from __future__ import annotations

from dataclasses import replace

from ucon.lives.clock import N_SLOTS
from ucon.lives.life import Life
from ucon.lives.sets import load_lives

#: Lives of the mini set in small homes, in both of which habits change.
SMALL = (1, 3)


def short_life(number: int = SMALL[0], requests: int = 6, days: int = 2) -> Life:
    """The first requests of a life of the mini set.

    Args:
        number: of the life.
        requests: how many of them.
        days: of the short life; where habits change, they do on its last day.
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
