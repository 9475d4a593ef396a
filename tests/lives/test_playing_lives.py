"""``eval.py task=resident``: the same records with any workers, and after an interruption within a life."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from models.agents.frontier import FrontierAgent
from models.agents.oracle_habits import OracleHabitsAgent
from models.agents.oracle_now import OracleNowAgent
from models.agents.random import RandomAgent
from tests.lives.short import SMALL, short_life
from tests.models.playing import config_of
from ucon.core.errors import ConfigError, UconError
from ucon.envs.resident import UcONResidentEnv
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.record import read_records, to_lines
from ucon.evaluation.kept.seal import DECISIONS, PARTIAL, RECORDS, SUMMARY
from ucon.evaluation.playing.jobs import shares
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.lives.asked import asked_of
from ucon.lives.sets import save_lives
from ucon.memory.map_memory import MapMemory
from ucon.memory.sightings_memory import SightingsMemory
from ucon.programs.evaluating import Evaluation

#: Number of requests in each of the two lives.
EACH = 5


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lives")
    save_lives([short_life(number, requests=EACH) for number in SMALL], folder / "two.lives.xz")
    return folder


def run_of(base: Path, out: Path, *words: str, agent: str = "frontier", memory: str = "sightings") -> Evaluation:
    options = ("task=resident", f"memory={memory}", f"episodes={base / 'two.lives.xz'}", "habit_level=gt")
    quiet = ("progress=false", "pictures=0", "workers=0")
    return Evaluation(config_of(agent, *options, *quiet, f"out={out}", *words), out)


@pytest.fixture(scope="module")
def whole(base: Path) -> Path:
    """The folder of an uninterrupted run; next to it, its partial file as it was at the end."""
    patch, finish = pytest.MonkeyPatch(), RunFolder.finish

    def keep_partial(self: RunFolder, *arguments: Any) -> None:
        shutil.copy(self.path / PARTIAL, base / PARTIAL)
        finish(self, *arguments)

    with patch.context() as patched:
        patched.setattr(RunFolder, "finish", keep_partial)
        run = run_of(base, base / "run")
        run.play()
    assert run.n_new == 2 * EACH
    return (base / "run").rename(base / "whole")


def test_records_tell_life_and_memory(base: Path, whole: Path) -> None:
    records = read_records(whole)
    lives = [short_life(number, requests=EACH) for number in SMALL]
    assert [r.episode for r in records] == [one.id for one in asked_of(lives)]
    assert [r.life and r.life.request for r in records] == [*range(EACH), *range(EACH)]
    assert any(r.life is not None and r.life.moved is not None for r in records)
    assert sum(r.success for r in records) >= EACH
    run = run_of(base, whole, f"out={base / 'run'}")
    assert run.label == "frontier + memory of map and sightings"
    assert run.play()["memory"] == "map and sightings"
    assert run.n_new == 0


@pytest.mark.parametrize("word", ["workers=1", "workers=2", "batch=2"])
def test_workers_and_batch_change_no_record(base: Path, whole: Path, word: str, tmp_path: Path) -> None:
    run_of(base, tmp_path / "run", word).play()
    assert (tmp_path / "run" / RECORDS).read_bytes() == (whole / RECORDS).read_bytes()
    assert (tmp_path / "run" / DECISIONS).read_bytes() == (whole / DECISIONS).read_bytes()


#: Finished requests: the first ones, up to the second life, as two workers leave them, and with gaps.
KEPT = [(0, 1, 2), (0, 1, 2, 3, 4, 5), (0, 5, 6), (1, 3, 9)]


@pytest.mark.parametrize("kept", KEPT)
def test_interrupted_within_a_life_and_continued_it_is_the_same_run(
    base: Path, whole: Path, kept: Sequence[int]
) -> None:
    lines, out = (base / PARTIAL).read_bytes().splitlines(keepends=True), base / "run"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    (out / PARTIAL).write_bytes(lines[0] + b"".join(lines[1 + k] for k in kept) + lines[-1][:50])
    run = run_of(base, out)
    run.play()
    assert run.n_new == 2 * EACH - len(kept)
    for name in (RECORDS, DECISIONS, SUMMARY):
        assert (out / name).read_bytes() == (whole / name).read_bytes(), name


def test_a_memory_makes_another_run(base: Path, whole: Path) -> None:
    again = shutil.copytree(whole, base / "again")
    with pytest.raises(ConfigError, match="another run"):
        run_of(base, again, memory="none").play()


@pytest.mark.slow
def test_belief_with_habits_plays_alike_in_workers(base: Path, tmp_path: Path) -> None:
    found = []
    for count in (0, 2):
        out = tmp_path / str(count)
        run_of(base, out, f"workers={count}", "habit_level=retrieval", agent="belief").play()
        found.append((out / RECORDS).read_bytes())
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("memory=sightings",), "add task=resident"),
        (("memory=map", "episodes=mini"), "add task=resident"),
        (("task=resident", "episodes=mini"), "set of lives"),
        (("task=resident", "episodes=lives_mimi"), "lives_mini"),
        (("task=resident", "limit=0"), "limit"),
        (("episodes=lives_mini",), "lives_mini"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    with pytest.raises(UconError, match=said) as raised:
        Evaluation(config_of("frontier", *words, f"out={tmp_path}"), tmp_path)
    assert "\n" not in str(raised.value)


def test_limit_and_every_count_lives(base: Path) -> None:
    lives = [short_life(number, requests=EACH) for number in SMALL]
    for words, wanted in ((("limit=1",), lives[:1]), (("every=2",), lives[:1]), (("limit=3",), lives)):
        run = run_of(base, base / "none", *words)
        assert [one.id for one in run.episodes] == [one.id for one in asked_of(wanted)]


def test_what_an_agent_is_given_of_a_request(base: Path) -> None:
    run = run_of(base, base / "none", "habit_level=full", agent="belief")
    told = run.given(run.episodes[0])
    assert told is not None
    assert len(told) > 20
    assert run_of(base, base / "none", memory="map").given(run.episodes[0]) is None
    assert run_of(base, base / "none", memory="sightings", agent="frontier").given(run.episodes[0]), "for its news"


def spec(agent: Any, life: Any, memory: Any, **options: Any) -> RunSpec:
    env = partial(UcONResidentEnv, [life], observe="symbolic", detector=True, planner="true", **options)
    return RunSpec(agent, env, "gt", memory=memory)


class Listening(FrontierAgent):
    """Notes the keys of every info that it gets."""

    told: set[str] = set()  # noqa: RUF012 (of all instances: the runner makes them)

    def reset(self, infos: Any, slots: Any = None) -> None:
        self.told.update(*infos)
        super().reset(infos, slots)

    def act(self, observations: Any, infos: Any, slots: Any = None) -> list[int]:
        self.told.update(*infos)
        return super().act(observations, infos, slots)


def test_the_record_of_a_request_does_not_reach_the_agent() -> None:
    """The record of a request, with privileged facts such as whether the thing was moved, is not in the next info."""
    life = short_life(requests=3)
    played = evaluate(spec(Listening, life, SightingsMemory), asked_of([life]), workers=0)
    assert len(played) == 3
    assert {"clock", "kept_map"} <= Listening.told
    assert not {"request_record", "is_success", "episode_metrics", "privileged", "life"} & Listening.told


@pytest.mark.parametrize("memory", [MapMemory, SightingsMemory])
def test_who_keeps_no_map_has_nothing_to_remember(memory: Any) -> None:
    life = short_life(requests=2)
    with pytest.raises(ConfigError, match="this agent keeps no map") as raised:
        evaluate(spec(RandomAgent, life, memory), asked_of([life]), workers=0)
    assert "\n" not in str(raised.value)
    assert len(evaluate(spec(RandomAgent, life, None), asked_of([life]), workers=0)) == 2


def test_who_is_told_the_place_walks_there() -> None:
    life = short_life(0, requests=4)
    told, alone = (
        evaluate(spec(agent, life, MapMemory, privileged=True), asked_of([life]), workers=0)
        for agent in (OracleNowAgent, FrontierAgent)
    )
    assert all(p.record.success for p in told)
    assert sum(p.record.steps for p in told) < sum(p.record.steps for p in alone)
    with pytest.raises(ConfigError, match="agent oracle_now needs the target's place"):
        evaluate(spec(OracleNowAgent, life, MapMemory), asked_of([life]), workers=0)


def test_who_knows_the_habits_to_the_letter_finds_more() -> None:
    life = short_life(0, requests=4)
    told, anchors, alone = (
        evaluate(spec(agent, life, SightingsMemory, privileged=True), asked_of([life]), workers=0)
        for agent in (OracleHabitsAgent, partial(OracleHabitsAgent, points=False), FrontierAgent)
    )
    assert sum(p.record.success for p in told) >= sum(p.record.success for p in alone)
    assert sum(p.record.steps for p in told) < sum(p.record.steps for p in alone)
    assert [p.record.actions for p in anchors] != [p.record.actions for p in told]
    with pytest.raises(ConfigError, match="agent oracle_habits needs a life and its rules: task=resident"):
        evaluate(spec(OracleHabitsAgent, life, MapMemory), asked_of([life]), workers=0)


def test_shares_hold_whole_lives() -> None:
    jobs = list(enumerate(asked_of([short_life(1, requests=3), short_life(3, requests=2)])))
    assert shares(jobs, 2) == [jobs[:3], jobs[3:]]
    assert shares(jobs, 5) == [jobs[:3], jobs[3:]]
    assert shares(jobs, 1) == [jobs]


def test_a_request_goes_as_it_went_whatever_else_is_wanted() -> None:
    life = short_life(requests=4)
    asked = asked_of([life])
    every, last = (
        evaluate(spec(FrontierAgent, life, SightingsMemory), asked, workers=0, skip=skip) for skip in ((), (0, 1, 2))
    )
    assert [p.index for p in last] == [3]
    assert to_lines([last[0].record]) == to_lines([every[3].record])
