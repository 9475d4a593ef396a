"""A run of a random agent on six episodes, for tests of the runner."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from models.agents.random import RandomAgent
from ucon.envs.ucon_env import UcONEnv
from ucon.evaluation.kept.record import to_lines
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.task.episode import Episode
from ucon.task.sets import load_episodes

N = 6


def six_episodes() -> tuple[Episode, ...]:
    return load_episodes("mini")[:N]


def random_run() -> RunSpec:
    env = partial(UcONEnv, six_episodes()[:1], habit_level="retrieval", observe="symbolic", privileged=True)
    return RunSpec(partial(RandomAgent, seed=4, done_probability=0.02), env, "retrieval", seed=4)


def lines(played: Iterable[PlayedEpisode]) -> str:
    """The records as written, sorted by episode."""
    return to_lines(p.record for p in sorted(played, key=lambda p: p.record.episode))
