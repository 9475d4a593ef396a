"""Steps to look around before the first request of a day: they reveal nothing of it, and it begins where they end."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import ucon.envs
from models.agents.frontier import FrontierAgent
from tests.lives.short import SMALL, short_life
from tests.models.playing import config_of
from ucon.core.errors import ActionError, ConfigError, EpisodeError
from ucon.envs.checking.findings import same
from ucon.envs.resident import UcONResidentEnv
from ucon.evaluation.kept.folder import RunFolder
from ucon.evaluation.kept.record import read_records
from ucon.evaluation.kept.seal import PARTIAL, RECORDS
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.lives.asked import asked_of
from ucon.lives.life import Life
from ucon.lives.sets import save_lives
from ucon.memory.map_memory import MapMemory
from ucon.memory.sightings_memory import SightingsMemory
from ucon.perception.detectors.gt import GtDetector
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.programs.evaluating import Evaluation
from ucon.task.actions import Action

assert ucon.envs

STEPS = 12
WALK = (0, 0, 1, 0, 2, 3, 5, 4, 0, 0, 2)
#: Keys of info on a patrol.
ALLOWED = {
    "target", "episode", "task", "habit_level", "habits", "nav", "depth", "camera_m", "fov_deg", "detections", "tracks",
    "opened", "clock", "patrol",
}  # fmt: skip


@pytest.fixture(scope="module")
def life() -> Life:
    return short_life(requests=6)


def made(life: Life, **options: Any) -> UcONResidentEnv:
    defaults = {"observe": "symbolic", "detector": True, "planner": "true", "habit_level": "full"}
    return UcONResidentEnv([life], **{"patrol": STEPS} | defaults | options)


def walked(env: UcONResidentEnv, actions: Sequence[int]) -> list[tuple[Any, Any]]:
    frames = [env.reset(seed=0)]
    for action in actions:
        observation, reward, over, truncated, info = env.step(action)
        assert (reward, over, truncated) == (0.0, False, False)
        frames.append((observation, info))
    return frames


@pytest.fixture(scope="module")
def frames(life: Life) -> list[tuple[Any, Any]]:
    return walked(made(life, privileged=True), WALK)


def test_nothing_of_the_request_is_told(frames: list[tuple[Any, Any]]) -> None:
    for number, (observation, info) in enumerate(frames):
        assert set(info) <= ALLOWED, set(info) - ALLOWED
        assert (info["target"], info["habits"], info["patrol"]) == ("", (), STEPS - number)
        for name in ("target", "habits", "habits_mask"):
            assert not np.any(observation[name]), name
        assert info["clock"] == tuple(observation["clock"].tolist())


@pytest.mark.parametrize("detector", [GtDetector, NoisyDetector])
def test_whatever_is_asked_for_the_walk_is_the_same(life: Life, detector: Any) -> None:
    """If the first request is for another thing, every frame of the patrol is the same to the byte."""
    first, others = life.requests[0], {one.possession for one in life.requests}
    other = next(k for k in others if k != first.possession)
    asked = replace(life, requests=(replace(first, possession=other), *life.requests[1:]))
    found = [walked(made(one, detector=detector()), WALK) for one in (life, asked)]
    for (observation, info), (observation_2, info_2) in zip(*found, strict=True):
        assert same(observation, observation_2)
        assert same(info, info_2)


def test_the_request_begins_where_the_robot_stands_when_the_steps_are_over(life: Life) -> None:
    env = made(life)
    walked(env, WALK)
    before = env.search_env.search.pose
    observation, reward, over, truncated, info = env.step(Action.ROTATE_LEFT)
    after = env.search_env.search.pose
    assert (after.i, after.j) == (before.i, before.j)
    assert (reward, over, truncated) == (0.0, False, False)
    assert (info["new_request"], info["request"], int(observation["step"][0])) == (True, 0, 0)
    assert "patrol" not in info
    assert info["target"] == env.episode.target_category
    assert len(info["habits"]) == len(info["habit_days"]) > 0
    assert env.episode.start.i == before.i
    assert "request_record" not in info


def test_done_ends_it_at_once_and_ends_no_request(life: Life) -> None:
    env = made(life)
    env.reset()
    env.step(0)
    info = env.step(Action.DONE)[-1]
    assert (info["new_request"], info["request"]) == (True, 0)
    *_, info = env.step(Action.DONE)
    assert info["request_record"]["steps"] == 1


def test_it_is_walked_on_the_first_request_of_each_day_alone(life: Life) -> None:
    env = made(life)
    _, info = env.reset()
    walks, over, days = 0, False, set()
    while not over:
        if "patrol" in info:
            assert info["patrol"] == STEPS
            walks += 1
            days.add(info["clock"][0])
        *_, over, _, info = env.step(Action.DONE)
    assert walks == len(days) == len({one.time // 3 for one in life.requests})


def test_steps_of_the_request_are_all_left(life: Life) -> None:
    env = made(life, patrol=30)
    walked(env, [Action.ROTATE_LEFT] * 29)
    env.step(Action.ROTATE_LEFT)
    for step in range(1, 300):
        observation, _, _, _, info = env.step(Action.ROTATE_LEFT)
        assert int(observation["step"][0]) == step
    *_, info = env.step(Action.ROTATE_LEFT)
    assert info["request_record"]["steps"] == 300


def test_a_bad_action_takes_no_step(life: Life) -> None:
    env = made(life)
    env.reset()
    with pytest.raises(ActionError, match="action=7") as raised:
        env.step(7)
    assert "\n" not in str(raised.value)
    assert env.step(0)[-1]["patrol"] == STEPS - 1


def test_a_reset_within_a_patrol_begins_another_one(life: Life) -> None:
    env = made(life)
    first = walked(env, WALK[:4])
    again = walked(env, WALK[:4])
    for one, other in zip(first, again, strict=True):
        assert same(one[0], other[0])
        assert same(one[1], other[1])
    with pytest.raises(EpisodeError):
        env.reset(options={"life": "nobody"})
    with pytest.raises(EpisodeError, match="step before reset"):
        env.step(0)


@pytest.mark.parametrize("patrol", [-1, 1.5, True, 300, 10**9, "150", None, [150]])
def test_steps_that_cannot_be_are_refused_in_one_line(life: Life, patrol: Any) -> None:
    with pytest.raises(ConfigError, match=r"env\.patrol=.*expected steps a day") as raised:
        UcONResidentEnv([life], patrol=patrol)
    assert "\n" not in str(raised.value)


@pytest.mark.filterwarnings("ignore:.*")
@pytest.mark.parametrize("observe", ["pixels", "symbolic"])
def test_gymnasium_check_env(life: Life, observe: str) -> None:
    env = gym.make("UcONResident-v0", lives=[life], observe=observe, patrol=STEPS, render_mode="rgb_array")
    check_env(env.unwrapped)


@pytest.mark.filterwarnings("ignore:.*")
def test_torchrl_accepts_it(life: Life) -> None:
    envs = pytest.importorskip("torchrl.envs")
    env = gym.make("UcONResident-v0", lives=[life], observe="symbolic", patrol=STEPS)
    envs.utils.check_env_specs(envs.GymWrapper(env))


@pytest.mark.parametrize("memory", [None, MapMemory])
def test_who_remembers_no_places_walks_none(life: Life, memory: Any) -> None:
    """The records equal those without a patrol, to the byte."""
    found = []
    for patrol in (0, 150):
        env = partial(made, life, patrol=patrol)
        played = evaluate(RunSpec(FrontierAgent, env, "full", memory=memory), asked_of([life]), workers=0)
        found.append([p.record for p in played])
    assert found[0] == found[1]


def test_sightings_of_the_walk_are_remembered_at_the_first_request(life: Life) -> None:
    memory = SightingsMemory()
    sizes = []
    begin = memory.begin

    def noted(info: Any) -> dict[str, Any]:
        given = begin(info)
        sizes.append((memory._time, sum(len(one.seen) for one in memory.log.things.values())))
        return given

    memory.begin = noted  # type: ignore[method-assign]
    env = partial(made, life, patrol=100)
    played = evaluate(RunSpec(FrontierAgent, env, "full", memory=lambda: memory), asked_of([life]), workers=0)
    assert sizes[0][1] > 5
    assert [size for _, size in sizes] == sorted(size for _, size in sizes)
    assert played[0].record.life is not None
    for one in memory.log.things.values():
        assert [time for time, _ in one.seen] == sorted(time for time, _ in one.seen)


EACH = 5


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lives")
    save_lives([short_life(number, requests=EACH) for number in SMALL], folder / "two.lives.xz")
    return folder


def run_of(base: Path, out: Path, *words: str) -> Evaluation:
    options = ("task=resident", "memory=sightings", f"episodes={base / 'two.lives.xz'}", "habit_level=gt")
    quiet = ("progress=false", "pictures=0", "workers=0", "env.patrol=40")
    return Evaluation(config_of("frontier", *options, *quiet, f"out={out}", *words), out)


@pytest.mark.slow
def test_workers_and_an_interruption_change_no_record(base: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, finish = base / "run", RunFolder.finish

    def keep_partial(self: RunFolder, *arguments: Any) -> None:
        shutil.copy(self.path / PARTIAL, base / PARTIAL)
        finish(self, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(RunFolder, "finish", keep_partial)
        run_of(base, out).play()
    whole = (out / RECORDS).read_bytes()
    assert all(record.believed is not None for record in read_records(out))
    run_of(base, base / "workers", "workers=2").play()
    assert (base / "workers" / RECORDS).read_bytes() == whole
    lines = (base / PARTIAL).read_bytes().splitlines(keepends=True)
    for kept in ((0, 1), (0, 1, 2, 3, 4, 5, 6), (3, 8)):
        shutil.rmtree(out)
        out.mkdir()
        (out / PARTIAL).write_bytes(lines[0] + b"".join(lines[1 + k] for k in kept) + lines[-1][:40])
        run = run_of(base, out)
        run.play()
        assert run.n_new == 2 * EACH - len(kept)
        assert (out / RECORDS).read_bytes() == whole
