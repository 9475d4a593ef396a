"""Lives as data: stored and read back, refused if inconsistent, and the state of a home at a given time."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ucon.core.errors import EpisodeError
from ucon.habits.book import contexts_book
from ucon.lives.asking import Asking
from ucon.lives.check_life import check_life_home
from ucon.lives.clock import N_SLOTS, day_and_slot, time_of, weekday_of
from ucon.lives.life import Life, Move
from ucon.lives.making.days import USED
from ucon.lives.sets import life_sets, load_lives, save_lives
from ucon.lives.timeline import Timeline
from ucon.lives.verify import verify_life
from ucon.sim.cache import load_house
from ucon.sim.paths import distances
from ucon.sim.state import SceneState
from ucon.task.episode import Start


@pytest.fixture(scope="module")
def life():
    return next(life for life in load_lives("lives_mini") if life.change_day is not None)


def test_times_count_slots_from_the_first_morning():
    assert [day_and_slot(time_of(day, slot)) for day in (0, 13) for slot in range(N_SLOTS)] == [
        (day, slot) for day in (0, 13) for slot in range(N_SLOTS)
    ]
    assert weekday_of(3, first_weekday=5) == 1


@pytest.mark.parametrize("name", life_sets())
def test_every_set_is_stored_as_it_is_made(name, tmp_path):
    lives = load_lives(name)
    assert len({life.id for life in lives}) == len(lives)
    path = tmp_path / f"{name}.lives.xz"
    save_lives(lives, path)
    assert path.read_bytes() == life_sets()[name].read_bytes()
    assert load_lives(path)[0].hash == lives[0].hash


def test_a_life_holds(life):
    assert verify_life(life, contexts_book()) == []


def test_a_timeline_is_the_moves(life):
    timeline, now = Timeline(life), list(life.at_first)
    for time in range(N_SLOTS * life.days):
        for move in life.moves:
            if move.time == time:
                now[move.possession] = move.place
        assert timeline.at[time].tolist() == now
    assert 0.1 < (np.diff(timeline.at, axis=0) != 0).mean() < USED


def test_a_home_has_every_possession_once_at_any_time(life):
    house, timeline = load_house(life.scene), Timeline(life)
    for time in (0, N_SLOTS * life.days - 1):
        state = SceneState(house, timeline.arrangement(time))
        for number, one in enumerate(life.possessions):
            assert state.instances_of(one.category) == [house.n_instances + len(life.fixed) + number]
        assert state.free[life.dock.i, life.dock.j]


def test_habits_change_on_their_day_alone(life):
    changing = [k for k, one in enumerate(life.possessions) if one.later]
    assert 0.2 <= len(changing) / len(life.possessions) <= 0.25
    for k in changing:
        one = life.possessions[k]
        assert life.entries_at(k, life.change_day - 1) == one.entries
        assert life.entries_at(k, life.change_day) == one.later
        assert not set(one.entries) & set(one.later)


def test_what_is_told_grows_on_the_day_of_the_change(life):
    told, untold = Asking(life, contexts_book()), Asking(life, contexts_book(), told=False)
    before = dict(told.told_entries(life.change_day - 1))
    after = dict(told.told_entries(life.change_day))
    new = {name for one in life.possessions for name in one.later}
    assert set(after) - set(before) == new
    assert {after[name] for name in new} == {life.change_day}
    assert dict(untold.told_entries(life.days - 1)) == before


def test_a_request_starts_where_the_robot_stands(life):
    asking, number = Asking(life, contexts_book()), len(life.requests) - 1
    episode = asking.episode(number, life.dock)
    asked = life.requests[number]
    assert episode.target_category == life.possessions[asked.possession].category
    assert episode.arrangement.objects[episode.target] == Timeline(life).place(asked.possession, asked.time).object
    end = asking.episode(number, Start(*_goal(asking, episode), 0))
    assert 0 < end.shortest_path_m <= episode.shortest_path_m
    assert asking.standing(number, life.dock) == life.dock


def _goal(asking, episode):
    """A free node next to the start: the path from there differs by at most one move."""
    free = SceneState(asking.house, episode.arrangement).free
    i, j = episode.start.i, episode.start.j
    return next((i + di, j + dj) for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)) if free[i + di, j + dj])


def test_a_robot_steps_aside_for_what_was_put_where_it_stood(life):
    asking, timeline = Asking(life, contexts_book()), Timeline(life)
    for number, asked in enumerate(life.requests):
        for i, j in timeline.arrangement(asked.time).blocked:
            aside = asking.standing(number, Start(i, j, 2))
            assert (aside.i, aside.j) != (i, j)
            assert aside.heading == 2
            assert abs(aside.i - i) + abs(aside.j - j) <= 12
            return
    pytest.skip("nothing on the floor in this life")


@pytest.mark.parametrize(
    ("edit", "said"),
    [
        ({"format": 7}, "life format 7, expected 1"),
        ({"days": 0}, "days 0, expected 1 to"),
        ({"users": 9}, "users 9, expected 1 to 3"),
        ({"season": "monsoon"}, "season"),
        ({"first_weekday": 7}, "first_weekday 7"),
        ({"change_day": 99}, "change_day 99"),
        ({"at_first": []}, "at_first 0"),
        ({"requests": []}, "number of requests 0"),
        ({"moves": [[5, 0, 0, 0], [4, 0, 0, 0]]}, "time of a move"),
        ({"moves": [[5, 0, 99, 0]]}, "place of a move 99"),
        ({"moves": [[5, 99, 0, 0]]}, "possession of a move 99"),
        ({"requests": [[5, 0, 7, None]]}, "who asks 7"),
        ({"occasions": [[1, "riot/loud"]]}, "occasion"),
        ({"occasions": [[1, "guests/visit"], [1, "guests/party"]]}, "one occasion a day"),
        ({"dock": [0, 0, 9]}, "dock heading 9"),
        ({"possessions": [["mug"]]}, "not a usable life"),
        ({"task": "hopping"}, "hopping"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(life, edit, said):
    data = json.loads(json.dumps(life.to_json())) | edit
    with pytest.raises(EpisodeError, match=r"^lives\.xz:3: ") as raised:
        Life.from_json(data, where="lives.xz:3")
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("name", ["moves", "possessions", "dock", "scene"])
def test_a_missing_field_is_refused(life, name):
    data = life.to_json()
    del data[name]
    with pytest.raises(EpisodeError, match=name):
        Life.from_json(data)


def test_a_life_of_another_home_or_other_habits_is_refused(life):
    house = load_house(life.scene)
    with pytest.raises(EpisodeError, match="make the lives again"):
        check_life_home(replace(life, home_hash="0" * 64), house)
    with pytest.raises(EpisodeError, match="dock"):
        check_life_home(replace(life, dock=Start(0, 0, 0)), house)
    far = replace(life, fixed=(replace(life.fixed[0], anchor=10_000), *life.fixed[1:]))
    with pytest.raises(EpisodeError, match="which never moves"):
        check_life_home(far, house)
    with pytest.raises(EpisodeError, match="the dataset in use is"):
        Asking(replace(life, habits_hash="0" * 64), contexts_book())


def test_a_move_against_all_habits_is_found(life):
    k, n = next(
        (k, n) for k, one in enumerate(life.possessions) for n, place in enumerate(one.places) if not place.origins
    )
    wrong = replace(life, moves=(*life.moves, Move(N_SLOTS * life.days - 1, k, n, 0)))
    assert any("does not name this place" in line for line in verify_life(wrong, contexts_book()))


def test_a_file_that_was_cut_is_refused(tmp_path):
    path = tmp_path / "cut.lives.xz"
    path.write_bytes(life_sets()["lives_mini"].read_bytes()[:900])
    with pytest.raises(Exception, match="not a whole file of lives"):
        load_lives(path)
    with pytest.raises(EpisodeError, match="lives_mini"):
        load_lives("lives_mimi")


def test_a_robot_never_begins_in_a_corner_without_a_way_out(life):
    """From every starting node there is a way to the dock: no request begins in a pocket closed off by things."""
    asking, timeline = Asking(life, contexts_book()), Timeline(life)
    for number in (0, len(life.requests) // 2, len(life.requests) - 1):
        free = SceneState(asking.house, timeline.arrangement(life.requests[number].time)).free
        moves = distances(free, [(life.dock.i, life.dock.j)])
        for i, j in np.argwhere(asking.house.grid.free)[::7]:
            start = asking.standing(number, Start(int(i), int(j), 1))
            assert moves[start.i, start.j] >= 0


def test_a_robot_gets_out_of_a_pocket(life):
    """If all free nodes around its node are blocked, the robot is put outside."""
    asking = Asking(life, contexts_book())
    time, dock = life.requests[0].time, (life.dock.i, life.dock.j)
    free = SceneState(asking.house, asking.timeline.arrangement(time)).free
    far = max(np.argwhere(free).tolist(), key=lambda node: abs(node[0] - dock[0]) + abs(node[1] - dock[1]))
    around = [(far[0] + di, far[1] + dj) for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    closed = replace(life, fixed_blocked=(*life.fixed_blocked, *(node for node in around if free[node])))
    start = Asking(closed, contexts_book()).standing(0, Start(*far, 0))
    assert (start.i, start.j) != tuple(far)
