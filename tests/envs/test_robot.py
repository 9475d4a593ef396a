"""``task=real_robot`` as an environment: observations, refusals, reproducibility and rendering."""

from __future__ import annotations

import copy
import pickle
from functools import partial
from itertools import pairwise
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ucon.envs
from models.agents.oracle import OracleAgent
from models.agents.random import RandomAgent
from ucon.core.errors import ConfigError, EpisodeError
from ucon.envs.checking import check
from ucon.envs.checking.findings import same
from ucon.envs.checking.subject import Subject, reset, step, subject_of
from ucon.envs.image_goal import UcONImageGoalEnv
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.record import EpisodeRecord
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.runner import evaluate
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.task.expert import Expert
from ucon.task.robot.rig import RobotRig
from ucon.task.robot.search import RobotSearch
from ucon.task.sets import load_episodes

assert ucon.envs
EXACT = RobotRig.exact()
WALK = (0, 0, 1, 0, 5, 2, 0, 3, 0, 4, 0, 2, 0, 0, 5, 1)


def made(**options: Any) -> UcONEnv:
    return UcONEnv("mini", **{"task": "real_robot", "habit_level": "none", "observe": "symbolic"} | options)


def exact(**options: Any) -> UcONEnv:
    """The environment for ``check-env``, with an exact robot."""
    return made(**{"rig": EXACT, "observe": "pixels", "habit_level": "retrieval"} | options)


def played(env: UcONEnv, episode: int = 1) -> list[Any]:
    return [reset(env, episode), *(step(env, action) for action in WALK)]


def records(agent: Any, workers: int, **options: Any) -> list[EpisodeRecord]:
    env = partial(made, detector=True, privileged=agent is OracleAgent, **options)
    spec = RunSpec(agent, env, "none")
    return [p.record for p in evaluate(spec, load_episodes("mini", "real_robot")[:6], workers=workers)]


def test_it_tells_pose_depth_and_rig_and_no_true_grid() -> None:
    env = made(observe="pixels")
    obs, info = env.reset(options={"episode": 0})
    assert (info["task"], info["fov_deg"], info["camera_m"]) == ("real_robot", 60.0, pytest.approx(0.9))
    assert "nav" not in info
    assert obs["pose"].tolist() == [0.0, 0.0, 0.0, 0.0]
    assert obs["depth"].max() <= 6.1
    assert env.observation_space.contains(obs)
    for action in (2, 2, 0, 0, 1):
        obs, *_ = env.step(action)
        assert env.observation_space.contains(obs)
        off = np.degrees(obs["pose"][2]) % 60.0
        assert min(off, 60.0 - off) < 5.0
    assert isinstance(env.search, RobotSearch)
    assert (obs["depth"] == 0).any()


@pytest.mark.parametrize("detector", [True, NoisyDetector])
def test_the_same_bytes_again_in_copies_and_from_pickles(detector: Any) -> None:
    env = made(detector=detector if detector is True else detector())
    first = played(env)
    assert all(same(tuple(a), tuple(b)) for a, b in zip(first, played(env), strict=True))
    half = [reset(env, 1), *(step(env, action) for action in WALK[:8])]
    copies = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    for one in (*copies, env):
        rest = [step(one, action) for action in WALK[8:]]
        assert all(same(tuple(a), tuple(b)) for a, b in zip(first[len(half) :], rest, strict=True))


def test_errors_follow_the_seed_of_the_rig() -> None:
    paths = [tuple(map(tuple, (s.obs["pose"] for s in played(made(rig=RobotRig(seed=seed)))))) for seed in (0, 0, 1)]
    assert paths[0] == paths[1] != paths[2]


@pytest.mark.parametrize(
    ("message", "make"),
    [
        (r"env.planner=true: .*observed", lambda: made(planner="true")),
        (r"env.rig: only for task=real_robot", lambda: made(task="paper", rig=EXACT)),
        (r"image goals.*real_robot", lambda: UcONImageGoalEnv("mini", task="real_robot", habit_level="none")),
        (r"field of view of 0", lambda: made(fov_deg=0.0)),
        (r"the expert.*real_robot", lambda: Expert(load_episodes("mini", "real_robot")[0])),
        (r"cannot be checked.*RobotRig.exact", lambda: subject_of("tests.envs.test_robot:made")),
    ],
)
def test_what_it_cannot_is_refused_in_one_line(message: str, make: Any) -> None:
    with pytest.raises(ConfigError, match=message) as error:
        make()
    assert "\n" not in str(error.value)


def test_a_body_too_large_for_the_start_is_refused() -> None:
    env, wide = made(rig=EXACT), made(rig=RobotRig(radius_m=0.3))
    env.reset(options={"episode": 0})
    tight = []
    for number in range(50):
        env.reset(options={"episode": number})
        if env.search.floor.clearance(*env.search.xy) < 0.3:  # type: ignore[attr-defined]
            tight.append(number)
    assert tight
    with pytest.raises(EpisodeError, match=r"radius 0\.3 m touches something at the start"):
        wide.reset(options={"episode": tight[0]})


def test_the_oracle_finds_by_the_stored_solution() -> None:
    found = records(OracleAgent, 0, rig=EXACT)
    assert all(record.success and record.collisions == 0 for record in found)
    for record in found:
        assert 0.6 < record.spl <= 1.0
        assert record.path_length_m >= record.shortest_path_m > 0


def test_records_do_not_depend_on_the_workers() -> None:
    agent = partial(RandomAgent, seed=2, done_probability=0.02)
    assert records(agent, 0) == records(agent, 2)


def test_path_lengths_are_metres_moved_and_distances_fall_on_the_way() -> None:
    env = made(rig=RobotRig(), detector=None)
    for number in range(4):
        episode = env.episodes[number]
        env.reset(options={"episode": number})
        start_m, path = env.ledger.to_goal_m(), [env.search.xy]
        for digit in episode.solution[: len(episode.solution) // 2]:
            env.step(int(digit))
            path.append(env.search.xy)
        walked = sum(float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in pairwise(path))
        assert env.ledger.outcome().path_length_m == pytest.approx(walked)
        assert env.ledger.to_goal_m() >= start_m - walked - 0.2
        assert env.ledger.to_goal_m() < start_m


def test_pybullet_in_the_loop_walks_the_same_way() -> None:
    """Within 2 cm over 40 steps, since each contact may add an error of up to 5 mm."""
    for number in (1, 3):
        apart, flags = [], []
        compiled, live = made(rig=EXACT), made(rig=EXACT, world="live")
        envs = (compiled, live)
        rng = np.random.default_rng(number)
        for env in envs:
            env.reset(options={"episode": number})
        for _ in range(40):
            action = int(rng.choice([0, 0, 0, 1, 2, 5]))
            obs = [env.step(action)[0] for env in envs]
            flags.append(int(obs[0]["collision"][0]) == int(obs[1]["collision"][0]))
            apart.append(float(np.abs(obs[0]["pose"] - obs[1]["pose"]).max()))
        live.close()
        assert max(apart) < 0.02
        assert np.mean(flags) >= 0.95


def test_it_keeps_what_the_task_promises() -> None:
    subject = subject_of("tests.envs.test_robot:exact")
    assert isinstance(subject, Subject)
    findings = list(check(subject))
    assert len(findings) >= 14
    assert [finding.line() for finding in findings if not finding.ok] == []


def test_frames_show_a_robot_between_nodes() -> None:
    env = made(render_mode="rgb_array", rig=EXACT)
    env.reset(options={"episode": 0})
    one = env.render()
    env.step(2)
    two = env.render()
    assert one is not None
    assert two is not None
    assert not np.array_equal(one[:, :384], two[:, :384])
    assert not np.array_equal(one[:, 384:], two[:, 384:])


def test_a_tour_looks_along_six_headings() -> None:
    env = made(detector=True, privileged=True)
    _, info = env.reset(options={"episode": 2})
    yaws = {round(float(np.degrees(obs["pose"][2]))) for obs, _ in info["privileged"]["tour"]()}
    assert yaws == {0, 60, 120, 180, -120, -60}


@pytest.mark.parametrize("kind", ["sync", "async"])
def test_vector_environments_play_it(kind: str) -> None:
    options = {"task": "real_robot", "habit_level": "none", "rig": RobotRig()}
    envs = gym.make_vec("UcON-v0", num_envs=2, vectorization_mode=kind, **options)
    try:
        envs.reset(seed=0)
        for action in (0, 2, 0):
            observations, *_ = envs.step(np.full(2, action))
        assert observations["pose"].shape == (2, 4)
        assert np.abs(observations["pose"][:, 2]).min() > 0.5
    finally:
        envs.close()
