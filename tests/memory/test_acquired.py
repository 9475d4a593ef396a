"""Habits that a robot has found out: their sentences, the counts in them, and when none is written."""

from __future__ import annotations

import numpy as np
import pytest

from ucon.lives.clock import time_of
from ucon.memory.acquired import acquired_habits, spoken, texts_of
from ucon.memory.sighting_log import SeenThing
from ucon.perception.belief.recalled import Spot

MORNING, MIDDAY, EVENING = range(3)
DESK, SOFA, NOWHERE = range(3)
SPOTS: list[Spot] = [(("ontop", "desk"), ("nextto", "table_lamp")), (("ontop", "sofa"),), ()]


def thing(*seen: tuple[int, int], spots: list[Spot] = SPOTS) -> SeenThing:
    return SeenThing("hardback", np.zeros((len(spots), 3)), list(seen), [], list(spots))


def said(one: SeenThing, first: int = 0, first_weekday: int = 0) -> list[tuple[Spot, str, int, int, int]]:
    habits = acquired_habits(one, first, first_weekday)
    return [(habit.spot, habit.when, habit.times, habit.of, habit.last_day) for habit in habits]


def days(*found: int, place: int = DESK, slot: int = MORNING) -> list[tuple[int, int]]:
    return [(time_of(day, slot), place) for day in found]


def test_the_sentence() -> None:
    (habit, *_) = acquired_habits(thing(*days(0, 1, 2)), 0, 0)
    assert habit.text == "The hardback has been on the desk, beside the table lamp, 3 of 3 times, last on day 3."
    assert texts_of([habit]) == (habit.text,)
    seen = [*days(0, 1, 2), *days(0, 1, 2, 3, 4, place=SOFA, slot=EVENING)]
    texts = texts_of(acquired_habits(thing(*sorted(seen)), 0, 0))
    assert "In the evening the hardback has been on the sofa, 5 of 5 times, last on day 5." in texts
    assert (
        "In the morning the hardback has been on the desk, beside the table lamp, 3 of 3 times, last on day 3." in texts
    )
    assert spoken(SPOTS[DESK]) == "on the desk, beside the table lamp"


def test_one_day_alone_is_no_habit() -> None:
    assert said(thing(*[(time_of(0, slot), DESK) for slot in range(3)])) == []
    assert said(thing(*days(0))) == []
    assert said(thing()) == []
    assert said(thing(*days(0, 1))) == [(SPOTS[DESK], "", 2, 2, 1)]


def test_several_sightings_in_a_slot_count_once_the_last() -> None:
    """Several sightings in a slot count as one; if they contradict each other, the last counts."""
    assert said(thing(*days(0, 0, 0, 0, 1, 1))) == [(SPOTS[DESK], "", 2, 2, 1)]
    assert said(thing(*days(0, 1), *days(1, place=SOFA))) == []


def test_a_quarter_of_all_times_at_least() -> None:
    """A thing that was on the desk on two of eight days, and on two of nine."""
    often = [*days(0), *days(1, 2, 3, place=SOFA), *days(4), *days(5, 6, 7, place=SOFA)]
    seldom = [*often, *days(8, place=SOFA)]
    assert (SPOTS[DESK], "", 2, 8, 4) in said(thing(*often))
    assert (SPOTS[SOFA], "", 6, 8, 7) in said(thing(*often))
    assert not any(spot == SPOTS[DESK] for spot, *_ in said(thing(*seldom)))


def test_where_it_came_to_once_it_may_have_been_left_by_mistake() -> None:
    once = [*days(0, 1, 2), *days(3, 4, place=SOFA)]
    assert said(thing(*once)) == []
    again = thing(*once, *days(5))
    assert said(again) == [(SPOTS[DESK], "", 4, 6, 5)]


def test_only_what_was_seen_since_the_change_counts() -> None:
    one = thing(*days(0), *days(1, place=SOFA), *days(2, 3), *days(4, 5, place=SOFA))
    assert {spot for spot, *_ in said(one)} == {SPOTS[DESK], SPOTS[SOFA]}
    assert said(one, first=4) == [(SPOTS[SOFA], "", 2, 2, 5)]
    assert said(one, first=5) == []
    assert said(one, first=6) == []


def test_two_places_of_one_name_are_one_habit() -> None:
    one = thing(*days(0), *days(1, place=SOFA), spots=[SPOTS[DESK], SPOTS[DESK]])
    assert said(one) == [(SPOTS[DESK], "", 2, 2, 1)]


def test_places_without_a_name_are_left_out_of_all_counts() -> None:
    assert said(thing(*days(0, 1), *days(2, 3, place=NOWHERE))) == [(SPOTS[DESK], "", 2, 2, 1)]
    assert said(thing(*days(0, 1, 2, place=NOWHERE))) == []


@pytest.mark.parametrize("first_weekday", [0, 4])
def test_parts_of_the_week(first_weekday: int) -> None:
    weekend = [day for day in range(14) if (first_weekday + day) % 7 >= 5]
    workdays = [day for day in range(14) if day not in weekend]
    seen = sorted([*days(*workdays), *days(*weekend, place=SOFA)])
    found = said(thing(*seen), first_weekday=first_weekday)
    assert (SPOTS[SOFA], "at the weekend", 4, 4, weekend[-1]) in found
    assert (SPOTS[DESK], "on workdays", 10, 10, workdays[-1]) in found
    assert [row for row in found if row[1] == "at the weekend"] == [row for row in found if row[2:4] == (4, 4)]


def test_parts_of_the_day_are_named_where_they_differ() -> None:
    seen = sorted([*days(0, 1, 2), *days(0, 1, 2, place=SOFA, slot=MIDDAY)])
    found = said(thing(*seen))
    assert {when for _, when, *_ in found} == {"", "in the morning", "at midday"}
    always = said(thing(*sorted([*days(0, 1, 2), *days(0, 1, 2, slot=MIDDAY)])))
    assert [when for _, when, *_ in always] == [""]
    twice = said(thing(*sorted([*days(0, 1), *days(0, 1, 2, place=SOFA, slot=MIDDAY)])))
    assert not any(when == "in the morning" for _, when, *_ in twice), "two times are too few for a part of the day"


def test_the_surest_come_first_and_the_order_is_one() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        seen = sorted((int(t), int(rng.integers(2))) for t in rng.choice(42, 20, replace=False))
        found = acquired_habits(thing(*seen), 0, 3)
        assert [habit.times for habit in found] == sorted((habit.times for habit in found), reverse=True)
        assert len({(habit.spot, habit.when) for habit in found}) == len(found)
        for habit in found:
            assert 2 <= habit.times <= habit.of <= 20
            assert seen[0][0] // 3 <= habit.last_day <= seen[-1][0] // 3
