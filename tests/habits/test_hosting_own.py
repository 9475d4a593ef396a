"""A home hosts an entry if it can realise two of its placements, or the only one that it has."""

from __future__ import annotations

import pytest

from ucon.habits.hosting import Hosted
from ucon.habits.types import Entry, Habit, Placement

PLACES = tuple(Placement("ontop", anchor) for anchor in ("bed", "desk", "shelf"))


@pytest.mark.parametrize(
    ("n", "realisable", "ok"),
    [(3, (0, 2), True), (3, (1,), False), (2, (0,), False), (1, (0,), True), (1, (), False), (0, (), False)],
)
def test_which_entries_are_hosted(n: int, realisable: tuple[int, ...], ok: bool) -> None:
    entry = Entry("mug/0", "mug", "you", PLACES[:n], (Habit("A sentence."),))
    assert Hosted(entry, realisable).ok is ok
