"""Measures a long run of one environment in its own process: ``python -m tests.envs.soak UcON-v0 100000 500``.

Prints one line of JSON. Actions are drawn evenly from all but Done, so that every episode goes on for as long as asked;
in the resident environment they are drawn from all, so that requests end and follow one another.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import gymnasium as gym

import ucon.envs
from ucon.core.rng import stream
from ucon.lives.sets import load_lives
from ucon.task.actions import Action
from ucon.task.sets import load_episodes

assert ucon.envs  # which registers them

RESIDENT = "UcONResident-v0"
#: Parts in which growth is reported, to tell a leak (which grows steadily) from a cache (which stops growing).
PARTS = 5


def resident_mb() -> float:
    """Resident memory of this process in megabytes, after garbage collection."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


def made(name: str) -> tuple[gym.Env[Any, Any], list[dict[str, Any]]]:
    """The environment, and the options of ``reset`` for each episode or life of its mini set."""
    if name == RESIDENT:
        return gym.make(name, lives="lives_mini"), [{"life": number} for number in range(len(load_lives("lives_mini")))]
    return gym.make(name, detector=True), [{"episode": number} for number in range(len(load_episodes("mini")))]


def soak(name: str, steps: int, resets: int) -> dict[str, Any]:
    """Play random actions and measure memory and open files.

    Args:
        name: of the environment.
        steps: number of steps after the warm-up, evenly shared among resets.
        resets: number of resets after the warm-up, which has a fifth as many, and at least one per episode or life.

    Returns:
        ``warm_mb``, ``mb`` (resident megabytes after the warm-up, and after each part of the run), ``warm_files`` and
        ``files`` (open file descriptors likewise), the numbers of ``steps``, ``resets`` and ``homes`` entered, and
        ``seconds`` for the whole.
    """
    began = time.perf_counter()
    env, options = made(name)
    draw = stream(0, "soak", name)
    highest = len(Action) if name == RESIDENT else int(Action.DONE)
    taken, homes = 0, set()

    def play(turn: int, count: int) -> None:
        nonlocal taken
        env.reset(options=options[turn % len(options)])
        homes.add(env.unwrapped.episode.scene)  # type: ignore[attr-defined]
        for action in draw.integers(highest, size=count):
            _, _, terminated, truncated, _ = env.step(int(action))
            taken += 1
            if terminated or truncated:
                env.reset(options=options[turn % len(options)])

    each = steps // resets
    for turn in range(max(len(options), resets // 5)):  # every home has been loaded, and every cache has its content
        play(turn, each)
    warm, files, taken = resident_mb(), open_files(), 0
    grown, handles = [], []
    for turn in range(resets):
        play(turn, each)
        if (turn + 1) * PARTS % resets < PARTS:
            grown.append(resident_mb())
            handles.append(open_files())
    env.close()
    return {
        "warm_mb": warm,
        "mb": grown,
        "warm_files": files,
        "files": handles,
        "steps": taken,
        "resets": resets,
        "homes": len(homes),
        "seconds": time.perf_counter() - began,
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(soak(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))) + "\n")
