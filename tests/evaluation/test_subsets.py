"""Subsets by the target's place, taken only from the episode that a record belongs to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.evaluation.records import record
from ucon.envs.told.falsehoods import place_now
from ucon.evaluation.figures.subsets import (
    UNKNOWN,
    by_common_sense,
    by_variety,
    common_sense,
    is_against_common_sense,
    variety,
)
from ucon.evaluation.kept.record import read_records
from ucon.habits import book
from ucon.task.sets import load_episodes

RECORDS = read_records(Path(__file__).resolve().parents[2] / "results" / "learned-frontier")[::20]


def test_common_sense_is_the_readers_without_a_habit() -> None:
    from ucon.perception.belief.from_habits import ReadHabits

    episodes, read = {e.id: e for e in load_episodes("test")}, ReadHabits()
    for one in RECORDS[:5]:
        anchor = place_now(book(), episodes[one.episode]).anchor
        found = read({"target": one.target, "habits": (), "habit_level": "none"})
        share = found.p[found.names.index(anchor)].sum() if anchor in found.names else 0.0
        assert common_sense(one) == pytest.approx(share * len(found.names))
    against = [one for one in RECORDS if is_against_common_sense(one)]
    assert 0 < len(against) < len(RECORDS) / 2
    assert {by_common_sense(one) for one in against} == {"0-1 times chance"}


def test_variety_is_one_where_all_agree_and_grows_with_the_anchors() -> None:
    dataset = book()
    for category in dataset.categories[::40]:
        anchors = {place.anchor for entry in dataset.entries_of(category) for place in entry.placements}
        found = variety(category)
        assert found is not None
        assert 1.0 <= found <= len(anchors) + 1e-9
    assert variety("no such thing") is None
    assert {by_variety(one) for one in RECORDS} == {"1-15 anchors", "15-17 anchors", "from 17 anchors"}


def test_of_an_episode_that_is_in_no_set_nothing_is_known() -> None:
    """For an unknown id, or a known one with another home or target than in the set."""
    known = RECORDS[0]
    for other in (record(0), replace(known, scene="Rs_int~99"), replace(known, target="anvil")):
        assert common_sense(other) is None
        assert not is_against_common_sense(other)
        assert by_common_sense(other) == by_variety(other) == UNKNOWN
