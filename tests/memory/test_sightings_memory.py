"""Sightings that a robot logs in a life agree with where things truly were."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from models.agents.frontier import FrontierAgent
from tests.lives.short import short_life
from ucon.envs.frame import StartFrame
from ucon.envs.resident import UcONResidentEnv
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.lives.asked import asked_of
from ucon.lives.life import Life
from ucon.lives.timeline import Timeline
from ucon.memory.protocol import Info
from ucon.memory.sighting_log import SAME_M
from ucon.memory.sightings_memory import SightingsMemory
from ucon.perception.belief.recalled import Recalled
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.sim.cache import load_house
from ucon.sim.state import SceneState


class Kept(SightingsMemory):
    """The memory, which also notes what it gave to each search, and how much of the home was then explored."""

    def __init__(self) -> None:
        super().__init__()
        self.given: list[dict[str, Any]] = []
        self.known: list[int] = []

    def begin(self, info: Info) -> dict[str, Any]:
        self.given.append(super().begin(info))
        assert self.map is not None
        self.known.append(int(self.map.explored.sum()))
        return self.given[-1]


class Lived:
    """A life played by the frontier agent."""

    def __init__(self, life: Life, detector: Any = True) -> None:
        self.life, self.memory = life, Kept()
        env = partial(UcONResidentEnv, [life], observe="symbolic", detector=detector, planner="true")
        spec = RunSpec(FrontierAgent, env, "none", memory=lambda: self.memory)
        self.played: list[PlayedEpisode] = evaluate(spec, asked_of([life]), workers=0)

    def where(self, name: str, time: int) -> Any:
        """Centre of a possession at a time, metres in the frame of the dock."""
        house = load_house(self.life.scene)
        number = [one.category for one in self.life.possessions].index(name)
        state = SceneState(house, Timeline(self.life).arrangement(time))
        box = state.boxes[house.n_instances + len(self.life.fixed) + number]
        return StartFrame(self.life.dock).point(0.5 * (box[:3] + box[3:]), house.grid)


@pytest.fixture(scope="module", params=[1, 3])
def lived(request: pytest.FixtureRequest) -> Lived:
    return Lived(short_life(request.param, requests=10, days=3))


@pytest.fixture(scope="module")
def emptied() -> Lived:
    """A life in which the robot passes places where things were before."""
    return Lived(short_life(3, requests=10, days=3))


def test_things_are_remembered_where_they_were(lived: Lived) -> None:
    owned = {one.category for one in lived.life.possessions}
    sightings = [(name, *seen) for name, one in lived.memory.log.things.items() if name in owned for seen in one.seen]
    assert len(sightings) > 15
    away = [
        np.linalg.norm(lived.memory.log.things[name].places[place] - lived.where(name, time))
        for name, time, place in sightings
    ]
    # A place keeps the position of its first sighting, perhaps from one side only.
    assert np.median(away) < 0.1
    assert max(away) < SAME_M + 0.25


def test_places_that_were_shown_empty_were_empty(emptied: Lived) -> None:
    """Except for one in twenty: a small thing may show too few pixels although its centre is in view."""
    owned = {one.category for one in emptied.life.possessions}
    log = emptied.memory.log.things
    away = np.array([
        np.linalg.norm(one.places[place] - emptied.where(name, time))
        for name, one in log.items()
        if name in owned
        for time, place in one.absent
    ])  # fmt: skip
    assert len(away) > 40
    assert (away < SAME_M).mean() < 0.05


def test_with_a_detector_that_errs_most_is_right_and_what_was_recognised_has_a_size() -> None:
    lived = Lived(short_life(3, requests=10, days=3), NoisyDetector())
    owned = {one.category for one in lived.life.possessions}
    log = {name: one for name, one in lived.memory.log.things.items() if name in owned}

    def away(rows: str) -> Any:
        found = [(name, *row) for name, one in log.items() for row in getattr(one, rows)]
        return np.array([np.linalg.norm(log[name].places[at] - lived.where(name, time)) for name, time, at in found])

    assert len(away("seen")) > 15
    assert (away("seen") < 0.6).mean() > 0.85
    assert (away("absent") < SAME_M).mean() < 0.25  # a thing that is never detected is missed again and again
    known = np.concatenate([one.size.min(1) > 0.0 for one in log.values()])
    assert 0.2 < known.mean() < 1.0
    kept = lived.memory.map
    assert kept is not None
    assert kept.looks is not None


def test_what_was_found_is_remembered_at_that_time(lived: Lived) -> None:
    for played in lived.played:
        life, record = played.record.life, played.record
        assert life is not None
        if record.success:
            thing = lived.memory.log.things[record.target]
            assert 3 * life.day + life.slot in [time for time, _ in thing.seen]


def test_times_never_go_back_and_places_exist(lived: Lived) -> None:
    for one in lived.memory.log.things.values():
        for rows in (one.seen, one.absent):
            times = [time for time, _ in rows]
            assert times == sorted(times)
            assert all(0 <= place < len(one.places) for _, place in rows)
        assert not set(one.seen) & set(one.absent)


def test_searches_are_given_what_was_seen_before(lived: Lived) -> None:
    told = 0
    for number, (played, given) in enumerate(zip(lived.played, lived.memory.given, strict=True)):
        assert played.record.life is not None
        assert given["kept_map"] is lived.memory.map
        if played.record.life.seen_days_ago is None:
            continue
        recalled = given.get("recalled")
        if recalled is not None:
            assert isinstance(recalled, Recalled)
            assert len(recalled.p) == len(recalled.xyz)
            assert recalled.p.sum() <= 1.0
            told += 1
        assert number > 0
    assert "recalled" not in lived.memory.given[0]
    assert told >= 2


def test_explored_floor_never_shrinks(lived: Lived) -> None:
    assert lived.memory.known[0] == 0
    assert lived.memory.known == sorted(lived.memory.known)
    assert lived.memory.known[-1] >= lived.memory.known[1] > 100


def test_looks_are_of_their_request_alone_whoever_keeps_the_map() -> None:
    """If the memory gives only sentences to searches, the looks of each request still start from nothing."""
    life = short_life(3, requests=4, days=2)
    memory = SightingsMemory(recalls=False, acquires=True)
    env = partial(UcONResidentEnv, [life], observe="symbolic", detector=True, planner="true")
    near = []
    end = memory.end

    def noted() -> None:
        assert memory._looking is not None
        near.append(memory._looking._near.copy())
        end()

    memory.end = noted  # type: ignore[method-assign]
    evaluate(RunSpec(FrontierAgent, env, "none", memory=lambda: memory), asked_of([life]), workers=0)
    assert len(near) == 4
    for before, after in pairwise(near):
        assert (after[: len(before)] > before[: len(after)]).any(), "a look of the request before counts again"
