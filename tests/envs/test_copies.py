"""Copies and pickles of environments and agents are independent, but share what never changes."""

from __future__ import annotations

import copy
import pickle
import time
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import ucon.envs
from models.agents.belief import BeliefAgent
from ucon.core.errors import DataError, SceneError
from ucon.envs.checking.findings import same
from ucon.envs.checking.subject import OURS, choice, core, reset, step
from ucon.envs.ucon_env import UcONEnv
from ucon.habits.book import book, the_book
from ucon.perception.detectors.noisy import NoisyDetector
from ucon.retrieval.levels import LEVELS
from ucon.sim.cache import load_house, the_house

assert ucon.envs
WALK = (0, 0, 1, 0, 5, 2, 0, 3, 0, 4, 0, 2, 0, 0, 5, 1)
DETECTORS = {"gt": lambda: True, "noisy": NoisyDetector}


def on(env: Any, seen: Any, steps: int, start: int = 0) -> list[Any]:
    out = [seen]
    for k in range(start, start + steps):
        if out[-1].over:
            break
        out.append(step(env, choice(out[-1], k) if "action_mask" in out[-1].obs else WALK[k % len(WALK)]))
    return out[1:]


def equal(a: list[Any], b: list[Any]) -> bool:
    return len(a) == len(b) > 0 and all(same(tuple(x), tuple(y)) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", OURS)
def test_a_copy_goes_its_own_way(name: str, level: str, detector: str) -> None:
    def made() -> Any:
        env = gym.make(name, habit_level=level, detector=DETECTORS[detector](), disable_env_checker=True)
        return pickle.loads(pickle.dumps(copy.deepcopy(env)))  # before reset

    env, alone, half = made(), made(), 2 if name == "UcONSearch-v0" else 12
    first = reset(env, 1, seed=3)
    last = [first, *on(env, first, half)][-1]
    on(alone, reset(alone, 1, seed=3), half)
    twin, frozen = copy.deepcopy(env), pickle.dumps(env)
    on(twin, last, half, half + 1)  # other actions: they must not affect the others
    again, thawed = copy.deepcopy(env), pickle.loads(frozen)
    right = on(alone, last, half, half)
    assert equal(right, on(env, last, half, half))
    assert equal(right, on(again, last, half, half))
    assert equal(right, on(thawed, last, half, half))
    assert core(again).np_random.random() == core(env).np_random.random()


@pytest.mark.parametrize("name", OURS)
def test_copies_share_what_never_changes(name: str) -> None:
    env = OURS[name]()
    env.reset(options={"episode": 0})
    a, b = core(env), core(copy.deepcopy(env))
    assert a.episodes is b.episodes
    assert a.episode is b.episode
    assert a.source is b.source
    assert a._world.house is b._world.house
    assert a._world.free is b._world.free
    assert a._renderer.arena.tables is b._renderer.arena.tables  # until something is opened
    assert a._world.open is not b._world.open
    thawed = core(pickle.loads(pickle.dumps(env)))
    assert thawed._world.house is a._world.house
    assert thawed.source.dataset is book()
    assert len(pickle.dumps(OURS["UcON-v0"]())) < 2_000_000


@pytest.mark.parametrize(("name", "most_ms"), [("UcON-v0", 2.0), ("UcONSearch-v0", 5.0)])
def test_a_copy_is_cheap(name: str, most_ms: float) -> None:
    env = gym.make(name, disable_env_checker=True)
    on(env, reset(env, 1), 3)
    copy.deepcopy(env)
    begun = time.process_time()
    for _ in range(20):
        copy.deepcopy(env)
    assert (time.process_time() - begun) / 20 * 1000 < 2 * most_ms  # twice the limit, for a busy machine


def test_what_is_opened_in_one_stays_shut_in_the_other() -> None:
    env = UcONEnv("mini")
    episode = next(e for e in env.episodes if "5" in e.solution)
    env.reset(options={"episode": episode})
    until = episode.solution.index("5")
    for digit in episode.solution[:until]:
        env.step(int(digit))
    twin, plain = copy.deepcopy(env), copy.deepcopy(env)
    shut = plain.step(3)[0]["depth"]
    opened = twin.step(5)[0]["depth"]
    assert core(twin).search.opened.any()
    assert not core(env).search.opened.any()
    assert not np.array_equal(opened, env.step(1)[0]["depth"])
    env.step(2)
    assert np.array_equal(env.step(3)[0]["depth"], shut)


def test_an_agent_and_its_environment_are_copied_together() -> None:
    env, agent = UcONEnv("mini", observe="symbolic", habit_level="context", detector=True), BeliefAgent()
    obs, info = env.reset(options={"episode": 0})
    agent.reset([info])

    def play(env: UcONEnv, agent: BeliefAgent, obs: Any, info: Any, steps: int) -> tuple[list[int], Any, Any]:
        acts = []
        for _ in range(steps):
            acts += agent.act([obs], [info])
            obs, _, over, _, info = env.step(acts[-1])
            if over:
                break
        return acts, obs, info

    _, obs, info = play(env, agent, obs, info, 15)
    env2, agent2 = copy.deepcopy((env, agent))
    assert agent2.controllers[0].searcher.map is not agent.controllers[0].searcher.map  # type: ignore[attr-defined]
    there = play(env2, agent2, obs, info, 25)[0]
    assert play(env, agent, obs, info, 25)[0] == there
    assert len(set(there)) > 1


def test_what_a_pickle_names_is_checked() -> None:
    house = load_house("Rs_int")
    assert the_house("Rs_int", house.spec.hash) is house
    with pytest.raises(DataError, match="pickled as 000"):
        the_house("Rs_int", "0" * 64)
    assert the_book(book().sha256) is book()
    with pytest.raises(DataError, match="habit book 000"):
        the_book("0" * 64)


def test_what_holds_a_client_says_so() -> None:
    pytest.importorskip("pybullet", reason="PyBullet is not installed")
    env = UcONEnv("mini", world="live", observe="symbolic")
    env.reset(options={"episode": 0})
    for call in (copy.deepcopy, pickle.dumps):
        with pytest.raises(SceneError, match="world=live"):
            call(env)
    env.close()
