"""Distributes episodes over worker processes, of this machine or of a cluster, which changes no record.

Workers are started from a fork server (or spawned where there is none), never by forking this process with its threads.
A worker that fails ends the run with its traceback; one that dies or stops answering is replaced.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final, Protocol

from ucon.core.errors import ConfigError, brief
from ucon.core.pool import MakePool, local_pool, usable_cores
from ucon.evaluation.playing.crew import WorkerPool
from ucon.evaluation.playing.jobs import Job, play, shares
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.lives.asked import Asked
from ucon.task.episode import Episode

OnPlayed = Callable[[PlayedEpisode], None]


def resolve_workers(workers: int | str, n_episodes: int) -> int:
    """Number of worker processes, at most one per episode.

    Args:
        workers: ``auto`` for one per usable core, or a number; 0 plays in this process.
        n_episodes: number of episodes.

    Raises:
        ConfigError: neither ``auto`` nor a number from 0 up.
    """
    if workers == "auto":
        return max(1, min(usable_cores(), n_episodes))
    try:
        count = int(workers)
    except ValueError:
        count = -1
    if count < 0:
        raise ConfigError(f"workers={workers}: expected 'auto', or a number from 0 (in this process) up")
    return min(count, n_episodes)


class Runner(Protocol):
    """Plays jobs, in processes of this machine or of a cluster."""

    def play(self, spec: RunSpec, jobs: Sequence[Job], workers: int | str, timeout_s: float) -> Iterator[PlayedEpisode]:
        """Play jobs and yield episodes as they end, in any order.

        Args:
            spec: agent, environment, habit level.
            jobs: see :data:`Job`.
            workers: how many, or ``auto``.
            timeout_s: longest time in seconds that a worker may take for an episode; infinity for no limit.
        """
        ...

    @property
    def pool(self) -> MakePool:
        """Function that opens pools of its processes for other work, see :func:`ucon.core.pool.pools_from`."""
        ...


class LocalRunner:
    """Plays in processes of this machine. Which of them plays what is fixed beforehand."""

    def play(self, spec: RunSpec, jobs: Sequence[Job], workers: int | str, timeout_s: float) -> Iterator[PlayedEpisode]:
        """Play jobs and yield episodes as they end; for ``workers`` see :func:`resolve_workers`."""
        count = resolve_workers(workers, len(jobs))
        return play(spec, jobs) if count == 0 else _parallel(spec, jobs, count, timeout_s)

    pool = staticmethod(local_pool)


LOCAL: Final = LocalRunner()


def evaluate(
    spec: RunSpec,
    episodes: Sequence[Episode | Asked],
    *,
    workers: int | str = "auto",
    skip: Sequence[int] = (),
    on_played: OnPlayed | None = None,
    worker_timeout_s: float | None = None,
    runner: Runner = LOCAL,
) -> list[PlayedEpisode]:
    """Play all episodes except those at the indices ``skip``.

    Args:
        spec: agent, environment, habit level.
        episodes: what to play; their order gives the index of each.
        workers: see :func:`resolve_workers`.
        skip: indices that an earlier run has played.
        on_played: is called in this process with each episode as it ends, in any order.
        worker_timeout_s: longest time in seconds that a worker may take for an episode; None for no limit.
        runner: provides the workers.

    Returns:
        The episodes, sorted by index.

    Raises:
        UconError: raised by a worker, unchanged.
        EpisodeError: no worker finished an episode in time.
        WorkerError: a worker failed in another way, or every worker that tried an episode died.
    """
    done = set(skip)
    jobs: list[Job] = [(i, episode) for i, episode in enumerate(episodes) if i not in done]
    found = []
    for played in runner.play(spec, jobs, workers, _limit(worker_timeout_s)):
        found.append(played)
        if on_played is not None:
            on_played(played)
    return sorted(found, key=lambda p: p.index)


def _limit(timeout_s: Any) -> float:
    """Seconds; infinity for None."""
    if timeout_s is None:
        return math.inf
    if type(timeout_s) not in (int, float) or not 0 < timeout_s < math.inf:
        raise ConfigError(f"worker_timeout_s={brief(timeout_s)}: expected seconds above 0, or null for no limit")
    return float(timeout_s)


def _parallel(spec: RunSpec, jobs: Sequence[Job], count: int, timeout_s: float) -> Iterator[PlayedEpisode]:
    pool = WorkerPool(spec, timeout_s)
    try:
        yield from pool.play(shares(jobs, count))
    finally:
        pool.close()
