"""The cost of an environment: milliseconds per reset, megabytes, steps per second; and that nothing leaks.

Times are CPU times of this process, so a busy machine changes them little.
"""

from __future__ import annotations

import gc
import os
import sys
import time
from pathlib import Path
from statistics import median

import pytest

from tests.timing import where_it_was_set
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.bench_env import bench_environment
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

on_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")


@pytest.fixture(scope="module")
def many() -> tuple[Episode, ...]:
    """Twenty episodes, whose homes all stay cached."""
    return load_episodes("mini")[:20]


def resident_mb() -> float:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def play(env: UcONEnv, index: int) -> None:
    env.reset(options={"episode": index})
    for action in (0, 1, 5, 4):
        env.step(action)


@where_it_was_set
@pytest.mark.timed
def test_a_reset_takes_less_than_5_ms(many: tuple[Episode, ...]) -> None:
    env = UcONEnv(many)
    for index in range(len(many)):
        env.reset(options={"episode": index})
    seconds = []
    for turn in range(5 * len(many)):
        started = time.process_time()
        env.reset(options={"episode": turn % len(many)})
        seconds.append(time.process_time() - started)
    assert median(seconds) < 0.005


@on_linux
def test_an_environment_takes_less_than_5_mb(many: tuple[Episode, ...]) -> None:
    warm = UcONEnv(many, detector=True)
    for index in range(len(many)):
        play(warm, index)
    before = resident_mb()
    envs = [UcONEnv(many, detector=True) for _ in range(20)]
    for index, env in enumerate(envs):
        play(env, index)
    assert (resident_mb() - before) / len(envs) < 5.0


@on_linux
@pytest.mark.parametrize(
    ("world", "resets"),
    [("compiled", 500), ("live", 20), pytest.param("live", 500, marks=pytest.mark.slow)],
)
def test_resets_leak_nothing(many: tuple[Episode, ...], world: str, resets: int) -> None:
    chosen = many if world == "compiled" else many[1:2]
    env = UcONEnv(chosen, detector=True, world=world)
    for turn in range(max(3, len(chosen), resets // 5)):  # caches and the allocator's pools fill
        play(env, turn % len(chosen))
    memory, files = resident_mb(), open_files()
    for turn in range(resets):
        play(env, turn % len(chosen))
    assert resident_mb() - memory < 3.0
    assert open_files() == files
    env.close()


def test_steps_a_second(many: tuple[Episode, ...]) -> None:
    """Loose bounds; ``python -m ucon bench`` measures properly."""
    figures = bench_environment(many[1:4])
    assert figures["env_pixels_sps"] >= 1500
    assert figures["env_symbolic_sps"] >= 2000
    assert figures["env_with_resets_sps"] >= 700
    assert 0 < figures["search_decisions_per_s_worst"] <= figures["search_decisions_per_s"]
    assert 1 <= figures["search_steps_per_decision"] <= 300
