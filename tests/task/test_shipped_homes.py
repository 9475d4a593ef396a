"""The three homes of the real-robot setting, and the two cases."""

from __future__ import annotations

from collections import Counter
from functools import cache

import pytest

from ucon.envs.own_home import episodes_of, is_home_file, own_set, read_places
from ucon.sim.house import House
from ucon.sim.placement.spot import ANYWHERE
from ucon.task.own_home.building import build, unplaced
from ucon.task.own_home.placed import refusal, spots_of
from ucon.task.own_home.reading import read_home
from ucon.task.own_home.shipped import CASES, HOMES, home_path
from ucon.task.own_home.wish import OwnHome

AREAS_M2 = {"robot_flat": (28, 32), "robot_house": (86, 94), "robot_office": (52, 58)}


@cache
def home(name: str) -> tuple[OwnHome, House]:
    wish = read_home(HOMES[name])
    return wish, build(wish)[1]


@pytest.mark.parametrize("name", HOMES)
def test_a_home_is_built_as_it_is_written(name: str) -> None:
    wish, house = home(name)
    assert unplaced(wish, house) == []
    low, high = AREAS_M2[name]
    assert low <= house.spec.area_m2 <= high


@pytest.mark.parametrize("name", HOMES)
def test_there_are_200_searches_and_25_to_40_sentences(name: str) -> None:
    wish, _ = home(name)
    about = [habit.text for one in (*wish.requests, *wish.things) for habit in one.habits]
    assert 25 <= len(about) <= 40
    assert len(set(about)) == len(about)
    assert len(wish.requests) * wish.starts >= 200
    openings = Counter(" ".join(text.split()[:3]) for text in about)
    assert openings.most_common(1)[0][1] <= 2, "no template"
    assert not wish.others
    assert len(wish.things) >= 5, "sentences about things that are not asked for"


@pytest.mark.parametrize("name", HOMES)
def test_every_place_takes_its_thing_and_none_is_behind_a_door(name: str) -> None:
    wish, house = home(name)
    spots, kept = spots_of(wish, house), {one.target for one in (*wish.requests, *wish.things)}
    for one in (*wish.requests, *wish.things):
        for place in one.places:
            where = place.placement
            assert where.relation != "inside" or where.anchor in ("shelf", "bathtub"), "the robot has no arm"
            if where.anchor not in kept:
                spot = spots.get((one.target, where.relation, where.anchor), ANYWHERE)
                assert refusal(house, one.target, where, spot) is None, (one.target, where)


def test_names_stand_for_homes() -> None:
    assert all(is_home_file(name) for name in (*HOMES, *CASES))
    assert not is_home_file("robot")
    for name, case in CASES.items():
        wish = read_home(home_path(name))
        assert home_path(name) == HOMES[case.home]
        assert case.target in {one.target for one in wish.requests}
        assert case.day < wish.starts


@pytest.mark.slow
@pytest.mark.parametrize("task", ["paper", "real_robot"])
@pytest.mark.parametrize("name", HOMES)
def test_all_searches_can_be_made(name: str, task: str) -> None:
    made = own_set(HOMES[name], task)
    wish, _ = home(name)
    assert Counter(e.target_category for e in made.episodes) == {one.target: wish.starts for one in wish.requests}
    for case, what in CASES.items():
        if what.home == name:
            (episode,) = episodes_of(case, task)
            assert (episode.target_category, episode.seed) == (what.target, what.day)


def test_the_habits_say_where_things_are() -> None:
    """Read as the robot reads them, the habits give the right place for most requests of a home."""
    wish, house = home("robot_house")
    right = 0
    for one in wish.requests:
        names, p = read_places(one.target, [habit.text for habit in one.habits])
        order = sorted(range(len(names)), key=lambda k: -p[k].sum())
        best = next(names[k] for k in order if names[k] in house.categories or names[k] == "laptop")
        right += best in {place.placement.anchor for place in one.places}
    assert right >= 0.6 * len(wish.requests)
