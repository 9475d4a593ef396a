"""``UcONResident-v0``: Gymnasium's contract, requests that follow one another, and no privileged information."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import ucon.envs
from models.agents.oracle import OracleAgent
from tests.lives.short import short_life
from ucon.core.errors import ActionError, ConfigError, EpisodeError
from ucon.envs.checking.findings import same
from ucon.envs.frame import StartFrame
from ucon.envs.resident import UcONResidentEnv
from ucon.habits.book import contexts_book
from ucon.lives.clock import day_and_slot
from ucon.lives.life import Life
from ucon.lives.timeline import Timeline
from ucon.task.actions import Action
from ucon.task.episode import Start
from ucon.task.search import Pose

assert ucon.envs

ALLOWED = {
    "target", "episode", "task", "context", "told", "habit_level", "habits", "habit_rows", "habit_days", "nav", "depth",
    "camera_m", "fov_deg", "detections", "tracks", "opened", "clock", "new_request", "request", "is_success",
}  # fmt: skip
WALK = (0, 0, 1, 0, 2, 3, 5, 4, 4, 0, 0, 1, 5, 0)


@pytest.fixture(scope="module")
def life() -> Life:
    return short_life()


def made(life: Life, **options: Any) -> UcONResidentEnv:
    return UcONResidentEnv([life], **{"observe": "symbolic", "detector": True, "habit_level": "full"} | options)


def lived(env: UcONResidentEnv) -> Iterator[tuple[Pose, Any, Any]]:
    """True pose, observation and info of every frame of a life played by the oracle."""
    agent, over = OracleAgent(), False
    observation, info = env.reset(seed=0)
    while True:
        if info.get("new_request"):
            agent.reset([info])
        yield env.search_env.search.pose, observation, info
        if over:
            return
        observation, _, over, truncated, info = env.step(agent.act([observation], [info])[0])
        assert not truncated


@pytest.fixture(scope="module")
def frames(life: Life) -> list[tuple[Pose, Any, Any]]:
    return list(lived(made(life, privileged=True)))


@pytest.fixture(scope="module")
def begun(frames: list[tuple[Pose, Any, Any]]) -> list[int]:
    """Indices of the frames in which requests begin."""
    return [k for k, (_, _, info) in enumerate(frames) if info.get("new_request")]


@pytest.mark.filterwarnings("ignore:.*")
@pytest.mark.parametrize("observe", ["pixels", "symbolic"])
def test_gymnasium_check_env(life: Life, observe: str) -> None:
    env = gym.make("UcONResident-v0", lives=[life], observe=observe, render_mode="rgb_array")
    check_env(env.unwrapped)


def test_spaces_contain_what_is_observed(life: Life, frames: list[tuple[Pose, Any, Any]]) -> None:
    space = made(life).observation_space
    assert all(observation in space for _, observation, _ in frames)


def test_the_oracle_meets_every_request_by_the_shortest_path(life: Life, frames: list[tuple[Pose, Any, Any]]) -> None:
    records = [info["request_record"] for _, _, info in frames if "request_record" in info]
    assert [record["life"]["request"] for record in records] == list(range(len(life.requests)))
    assert [record["spl"] for record in records] == [1.0] * len(records)
    assert all(info["is_success"] for _, _, info in frames if "request_record" in info)


def test_a_life_ends_after_its_last_request(life: Life) -> None:
    env = made(life)
    env.reset()
    ends = []
    for _ in life.requests:
        _, _, over, truncated, info = env.step(Action.DONE)
        assert not truncated
        assert info["request_record"]["steps"] == 1
        assert bool(info.get("new_request")) != over
        ends.append(over)
    assert ends == [False] * (len(ends) - 1) + [True]
    with pytest.raises(EpisodeError, match=r"is over: call reset\(\) first$"):
        env.step(0)
    env.reset()
    assert env.request == 0


def test_a_request_ends_after_300_steps_and_the_life_goes_on(life: Life) -> None:
    env = made(life)
    env.reset()
    for number in range(1, 301):
        observation, _, over, truncated, info = env.step(Action.ROTATE_LEFT)
        assert not over
        assert not truncated
        assert ("request_record" in info) == (number == 300)
    assert not info["is_success"]
    assert info["new_request"]
    assert (int(observation["step"][0]), int(observation["request"][0])) == (0, 1)


def test_clock_and_number_are_those_of_the_request(
    life: Life, frames: list[tuple[Pose, Any, Any]], begun: list[int]
) -> None:
    assert [frames[k][2]["request"] for k in begun] == list(range(len(life.requests)))
    number = -1
    for _, observation, info in frames:
        number += bool(info.get("new_request"))
        day, slot = day_and_slot(life.requests[number].time)
        clock = (day, (life.first_weekday + day) % 7, slot)
        assert tuple(observation["clock"]) == info.get("clock", clock) == clock
        assert observation["request"] == number
    assert {day_and_slot(asked.time)[0] for asked in life.requests} == {0, 1}


def test_steps_are_counted_by_request(frames: list[tuple[Pose, Any, Any]], begun: list[int]) -> None:
    for first, after in zip(begun, [*begun[1:], len(frames)], strict=True):
        assert [int(frames[k][1]["step"][0]) for k in range(first, after)] == list(range(after - first))


def test_poses_are_relative_to_the_dock_for_the_whole_life(life: Life, frames: list[tuple[Pose, Any, Any]]) -> None:
    frame = StartFrame(life.dock)
    assert all((observation["pose"] == frame.pose(pose)).all() for pose, observation, _ in frames)


def test_the_robot_begins_where_it_stopped_and_in_the_morning_at_its_dock(
    life: Life, frames: list[tuple[Pose, Any, Any]], begun: list[int]
) -> None:
    days = [day_and_slot(asked.time)[0] for asked in life.requests]
    # Done, the last action of a request, does not move the robot: it stopped where it was in the frame before.
    dock = (life.dock.i, life.dock.j, life.dock.heading)
    where = [(frames[k][0].i, frames[k][0].j, frames[k][0].heading) for k in begun]
    before = [(frames[k - 1][0].i, frames[k - 1][0].j, frames[k - 1][0].heading) for k in begun[1:]]
    for number in range(1, len(begun)):
        assert where[number] == (before[number - 1] if days[number] == days[number - 1] else dock)
    assert where[0] == dock
    assert dock not in before
    assert days[-1] > days[0]


def test_a_request_begins_level_and_with_its_own_counts(frames: list[tuple[Pose, Any, Any]], begun: list[int]) -> None:
    for k in begun:
        assert frames[k][0].pitch_deg == 0
        assert not frames[k][1]["last_action"].any()


@pytest.mark.parametrize("told", [True, False])
def test_habits_have_the_day_on_which_they_were_told(life: Life, told: bool) -> None:
    env = made(life, told=told)
    _, info = env.reset()
    dataset, later = contexts_book(), {name for one in life.possessions for name in one.later}
    seen: set[tuple[bool, int]] = set()
    for number, asked in enumerate(life.requests):
        day = day_and_slot(asked.time)[0]
        assert len(info["habit_days"]) == len(info["habit_rows"]) == len(info["habits"])
        for row, since in zip(info["habit_rows"], info["habit_days"], strict=True):
            name = dataset.entry_of(row).id
            assert since == (life.change_day if name in later else 0) <= day
            seen.add((name in later, day))
        if number + 1 < len(life.requests):
            info = env.step(Action.DONE)[-1]
    assert ((True, 1) in seen) == told
    assert (True, 0) not in seen


def test_tracks_go_on_within_a_life_and_begin_anew_in_another(life: Life) -> None:
    env = made(life, privileged=True)
    number: dict[int, int] = {}
    for _, _, shown in lived(env):
        instance, tracks = env.search_env._instance, shown["tracks"]
        for k in np.unique(instance[(tracks >= 0) & (instance >= 0)]).tolist():
            (track,) = np.unique(tracks[(instance == k) & (tracks >= 0)])
            assert number.setdefault(k, int(track)) == track
    assert len(number) > 30
    assert len(set(number.values())) == len(number)
    _, info = env.reset()
    assert info["detections"].track.tolist() == list(range(len(info["detections"].track)))


def test_without_privileges_infos_hold_what_is_allowed(life: Life) -> None:
    env = made(life)
    _, info = env.reset()
    assert set(info) <= ALLOWED
    names = set(info)
    for number in range(len(life.requests)):
        for action in WALK[: 10 - number]:
            info = env.step(action)[-1]
            assert set(info) <= ALLOWED
        info = env.step(Action.DONE)[-1]
        assert set(info) - ALLOWED <= {"request_record", "episode_metrics"}
        assert "episode_metrics" not in info
        names |= set(info)
    assert "privileged" not in names
    assert {"clock", "habit_days", "told"} <= names
    assert "privileged" in made(life, privileged=True).reset()[1]


def test_a_place_that_is_not_in_view_leaves_no_trace(life: Life) -> None:
    """If the requested thing is at another place, the agent gets the same data until it sees the thing."""
    asked = life.requests[0].possession
    one, first = life.possessions[asked], int(Timeline(life).at[life.requests[0].time, asked])
    other = next(
        k for k, p in enumerate(one.places) if k != first and p.blocked == one.places[first].blocked and not p.blocked
    )
    moves = tuple(move for move in life.moves if move.possession != asked)
    envs = []
    for place in (first, other):
        at_first = (*life.at_first[:asked], place, *life.at_first[asked + 1 :])
        envs.append(made(replace(life, at_first=at_first, moves=moves)))
    a, b = (env.reset(seed=0) for env in envs)
    steps = 0
    for action in WALK:
        counts = [env.search_env.search.counts[env.search_env.search.target] for env in envs]
        if any(counts):
            break
        assert same(a, b)
        steps += 1
        a, b = (env.step(action) for env in envs)
    assert steps > 3
    assert envs[0].episode.arrangement != envs[1].episode.arrangement


def test_one_seed_gives_the_same_bytes() -> None:
    lives = [short_life(1), short_life(3)]
    runs = []
    for _ in range(2):
        env = UcONResidentEnv(lives, detector=True, habit_level="retrieval")
        runs.append([env.reset(seed=5), *(env.step(action) for action in (*WALK, 6, 0, 0, 1, 6, 0))])
    assert all(same(tuple(a), tuple(b)) for a, b in zip(*runs, strict=True))
    chosen = {env.reset(seed=seed) and env.life.id for seed in range(8)}
    assert chosen == {life.id for life in lives}


def test_a_copy_goes_its_own_way(life: Life) -> None:
    env = made(life)
    env.reset()
    env.step(Action.DONE)
    twin = copy.deepcopy(env)
    assert twin.life is env.life
    for _ in range(3):
        twin.step(Action.DONE)
    assert (env.request, twin.request) == (1, 4)
    other = made(life)
    other.reset()
    other.step(Action.DONE)
    for action in (*WALK, Action.DONE, *WALK):
        assert same(env.step(action), other.step(action))


def test_facts_of_a_request_are_what_the_robot_saw(life: Life, frames: list[tuple[Pose, Any, Any]]) -> None:
    timeline = Timeline(life)
    env, last = made(life, privileged=True), dict[int, tuple[int, int]]()
    first = 0
    for _, _, info in lived(env):
        if info.get("new_request"):
            number = info["request"]
            k, time = life.requests[number].possession, life.requests[number].time
            facts = env.facts
            assert (facts.life, facts.request, (facts.day, facts.slot)) == (life.id, number, day_and_slot(time))
            if k in last:
                assert facts.seen_days_ago == round((time - last[k][0]) / 3, 6)
                assert facts.moved == (last[k][1] != timeline.at[time, k])
            else:
                assert (facts.seen_days_ago, facts.moved) == (None, None)
            assert facts.changed == (facts.day >= life.change_day and bool(life.possessions[k].later))
            first += facts.seen_days_ago is None
        if "request_record" in info and not info.get("new_request"):
            break
        counts = env.search_env.search.counts
        at = life.requests[env.request].time
        for one in range(len(life.possessions)):
            if counts[len(counts) - len(life.possessions) + one] >= env.search_env.rules.done_min_pixels:
                last[one] = (at, int(timeline.at[at, one]))
    assert first >= 1
    assert frames[-1][2]["request_record"]["life"] == env.facts.to_json()


def test_the_level_of_one_life_and_its_choice(life: Life) -> None:
    other = short_life(3)
    env = UcONResidentEnv([life, other], observe="symbolic", habit_level="full")
    for wanted in (other, other.id, 1):
        env.reset(options={"life": wanted})
        assert env.life.id == other.id
    info = env.reset(options={"life": 0, "habit_level": "none"})[1]
    assert (info["habits"], info["habit_days"], info["habit_level"]) == ((), (), "none")
    assert env.step(Action.DONE)[-1]["habit_level"] == "none"
    assert env.reset(options={"life": 0})[1]["habit_level"] == "full"


def one_line(raised: pytest.ExceptionInfo[Exception]) -> None:
    assert "\n" not in str(raised.value)


def test_what_cannot_be_is_refused_in_one_line(life: Life) -> None:
    env = made(life)
    with pytest.raises(EpisodeError, match="step before reset"):
        env.step(0)
    for wanted, said in (("nobody", "no life 'nobody' among the 1 of"), (1, "life index 1, expected 0 to 0")):
        env.reset()
        with pytest.raises(EpisodeError, match=said) as raised:
            env.reset(options={"life": wanted})
        one_line(raised)
        with pytest.raises(EpisodeError, match="step before reset"):
            env.step(0)
    env.reset()
    with pytest.raises(ActionError, match="action=7"):
        env.step(7)
    assert env.request == 0
    with pytest.raises(EpisodeError, match="the dataset in use is"):
        env.reset(options={"life": replace(life, habits_hash="0" * 64)})
    with pytest.raises(EpisodeError, match="dock"):
        env.reset(options={"life": replace(life, dock=Start(0, 0, 0))})


@pytest.mark.parametrize(
    ("options", "error", "said"),
    [
        ({"lives": []}, EpisodeError, "no lives: expected at least one"),
        ({"lives": "lives_mimi"}, EpisodeError, "lives_mini"),
        ({"episodes": "mini"}, ConfigError, "a resident plays lives"),
        ({"max_habits": 3, "habit_level": "full"}, ConfigError, "max_habits"),
        ({"habit_level": "all"}, ConfigError, "all"),
    ],
)
def test_options_are_checked_in_one_line(
    life: Life, options: dict[str, Any], error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said) as raised:
        UcONResidentEnv(**{"lives": [life]} | options).reset()
    one_line(raised)


def told_at(life: Life, **options: Any) -> list[tuple[tuple[str, ...], tuple[int, ...]]]:
    """The habits at each request, and the days on which they were told."""
    env = made(life, **options)
    _, info = env.reset()
    found, over = [], False
    while not over:
        found.append((info["habits"], info["habit_days"]))
        *_, over, _, info = env.step(Action.DONE)
    return found


def test_replaced_sentences_are_told_on_or_no_longer(life: Life) -> None:
    """With stale=False, only the sentences that new ones replace are gone, from the day of the change on."""
    both, new, never = told_at(life), told_at(life, stale=False), told_at(life, stale=False, told=False)
    changed = [day_and_slot(one.time)[0] >= life.change_day for one in life.requests]  # type: ignore[operator]
    assert True in changed
    assert False in changed
    for number, after in enumerate(changed):
        if not after:
            assert both[number] == new[number] == never[number]
            continue
        assert set(new[number][0]) < set(both[number][0])
        assert set(never[number][0]) < set(new[number][0])
        news = {text for text, day in zip(*both[number], strict=True) if day == life.change_day}
        assert news == {text for text, day in zip(*new[number], strict=True) if day == life.change_day}
        assert not any(never[number][1])
        kept = [one for one in life.possessions if not one.later]
        assert len(new[number][0]) > len(kept)
