"""Spreads episodes over worker processes. Which worker plays what is fixed beforehand, and changes no record.

Workers start from a fork server (or afresh where there is none), never by forking this process with its threads.
A worker that fails ends the run with its own traceback; a worker that dies says with which exit code; one that stops
answering is replaced.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ucon.core.errors import ConfigError, brief
from ucon.evaluation.playing.crew import Crew
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec, play
from ucon.task.episode import Episode

OnPlayed = Callable[[PlayedEpisode], None]


def resolve_workers(workers: int | str, n_episodes: int) -> int:
    """Number of worker processes: ``auto`` is one a usable core; 0 plays in this process; never more than episodes."""
    if workers == "auto":
        usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return max(1, min(usable, n_episodes))
    try:
        count = int(workers)
    except ValueError:
        count = -1
    if count < 0:
        raise ConfigError(f"workers={workers}: expected 'auto', or a number from 0 (in this process) up")
    return min(count, n_episodes)


def evaluate(
    spec: RunSpec,
    episodes: Sequence[Episode],
    *,
    workers: int | str = "auto",
    skip: Sequence[int] = (),
    on_played: OnPlayed | None = None,
    worker_timeout_s: float | None = None,
) -> list[PlayedEpisode]:
    """Play all episodes but those at the indices ``skip``; sorted by index.

    Args:
        spec: agent, environment, habit level.
        episodes: what to play; their order gives the index of each.
        workers: see :func:`resolve_workers`.
        skip: indices that an earlier run has already played.
        on_played: called in this process with each episode as it ends, in no particular order.
        worker_timeout_s: the longest time that a worker may take for an episode; None for no limit.

    Raises:
        UconError: what a worker raised, unchanged.
        EpisodeError: no worker finished an episode in time.
        WorkerError: a worker failed in another way or died.
    """
    done = set(skip)
    jobs = [(i, episode) for i, episode in enumerate(episodes) if i not in done]
    count = resolve_workers(workers, len(jobs))
    limit = _limit(worker_timeout_s)
    source = play(spec, jobs) if count == 0 else _parallel(spec, jobs, count, limit)
    found = []
    for played in source:
        found.append(played)
        if on_played is not None:
            on_played(played)
    return sorted(found, key=lambda p: p.index)


def _limit(timeout_s: Any) -> float:
    """Seconds; None is no limit."""
    if timeout_s is None:
        return math.inf
    if type(timeout_s) not in (int, float) or not 0 < timeout_s < math.inf:
        raise ConfigError(f"worker_timeout_s={brief(timeout_s)}: expected seconds above 0, or null for no limit")
    return float(timeout_s)


def _parallel(
    spec: RunSpec, jobs: Sequence[tuple[int, Episode]], count: int, timeout_s: float
) -> Iterator[PlayedEpisode]:
    crew = Crew(spec, timeout_s)
    try:
        yield from crew.play([jobs[number::count] for number in range(count)])
    finally:
        crew.close()
