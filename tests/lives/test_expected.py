"""Where an observer who knows a household's rules expects things."""

from __future__ import annotations

import numpy as np
import pytest

from models.agents.oracle_habits import expected
from ucon.core.errors import ConfigError
from ucon.habits.book import contexts_book
from ucon.lives.clock import N_SLOTS
from ucon.lives.expected import expected_places
from ucon.lives.making.days import USED
from ucon.lives.sets import load_lives
from ucon.lives.timeline import Timeline


def draws(count: int, ago: int | None) -> list[tuple[float, float]]:
    """For things last seen ``ago`` slots ago: the probability of the true place, and its expected value."""
    rng, book = np.random.default_rng(0), contexts_book()
    lives = [(life, Timeline(life)) for life in load_lives("lives_val")[:6]]
    found = []
    for _ in range(count):
        life, timeline = lives[int(rng.integers(len(lives)))]
        k = int(rng.integers(len(life.possessions)))
        time = int(rng.integers(12 if ago is None else ago, N_SLOTS * life.days))
        seen = None if ago is None else (time - ago, int(timeline.at[time - ago, k]))
        p = expected_places(life, book, k, time, seen)
        assert p.sum() == pytest.approx(1.0)
        assert (p >= 0.0).all()
        found.append((float(p[timeline.at[time, k]]), float(p @ p)))
    return found


@pytest.mark.parametrize("ago", [1, 4, 10, None])
def test_it_is_calibrated(ago: int | None) -> None:
    """If things are distributed as p says, the mean probability of the true place is p . p."""
    got, due = np.array(draws(250, ago)).T
    assert got.mean() == pytest.approx(due.mean(), abs=0.055)
    assert due.mean() > 0.4


def test_what_was_seen_now_is_there_and_later_perhaps() -> None:
    life = load_lives("lives_mini")[0]
    now, next_slot = (expected_places(life, contexts_book(), 0, time, (5, 1)) for time in (5, 6))
    assert now[1] == 1.0
    assert 1.0 - USED <= next_slot[1] < 1.0


def test_who_is_not_told_the_rules_cannot_know_them() -> None:
    with pytest.raises(ConfigError, match="oracle_habits needs a life and its rules: task=resident"):
        expected({"privileged": {}})
