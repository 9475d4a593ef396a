"""Simulates how long a run takes on a cluster, with the crew's own rule for pieces and slow and failing workers."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from ucon.cluster.roles import piece_size
from ucon.core.errors import ConfigError, brief
from ucon.core.rng import stream

_HOUR: Final = 3600.0


@dataclass(frozen=True)
class Trouble:
    """How many workers are slow or lost, and what that costs in time.

    Raises:
        ConfigError: a number out of range.
    """

    lost_per_hour: float = 0.05
    """Workers lost, for each worker and hour."""
    slow_share: float = 0.05
    """Share of workers that are slow."""
    slowness: float = 2.0
    """How many times as long a slow worker takes."""
    start_s: float = 20.0
    """Seconds until a worker, or its replacement, begins."""
    found_s: float = 10.0
    """Seconds until a loss is noticed."""

    def __post_init__(self) -> None:
        bounds = {"lost_per_hour": (0, 60), "slow_share": (0, 1), "slowness": (1, 1000)}
        for name, (least, most) in (bounds | {"start_s": (0, 1e5), "found_s": (0, 1e5)}).items():
            value = getattr(self, name)
            if type(value) not in (int, float) or not least <= value <= most:
                raise ConfigError(f"{name}={brief(value)}: expected a number from {least} to {most:g}")


@dataclass(frozen=True)
class Schedule:
    """Wall time, work and losses of a simulated run."""

    workers: int
    wall_s: float
    """Seconds until the last job ends."""
    work_s: float
    """Worker seconds of the jobs themselves, each counted once."""
    again_s: float
    """Worker seconds spent on jobs that were cut off and begun again."""
    lost: int
    """Workers that were lost."""

    @property
    def efficiency(self) -> float:
        """Share of all workers' time that went into jobs that counted."""
        return self.work_s / (self.workers * self.wall_s)


def simulate(seconds: Sequence[float], workers: int, trouble: Trouble, *, at_once: int = 1, seed: int = 0) -> Schedule:
    """Simulate a run.

    Args:
        seconds: duration of each job, in order.
        workers: number of workers.
        trouble: what goes wrong.
        at_once: least number of jobs that a worker is given at once.
        seed: of losses and slow workers.

    Raises:
        ConfigError: no jobs, or no workers.
    """
    if not seconds or workers < 1:
        raise ConfigError(f"{len(seconds)} jobs for {workers} workers: expected at least one of each")
    draw = stream(seed, "schedule", workers)
    slow = draw.random(workers) < trouble.slow_share
    waiting = deque(range(len(seconds)))
    free = [(trouble.start_s, number) for number in range(workers)]
    idle: list[tuple[float, int]] = []
    back: list[tuple[float, list[int]]] = []
    wall = again = 0.0
    lost = 0
    heapq.heapify(free)
    while free or back:
        if back and (not free or back[0][0] <= free[0][0]):
            now, jobs = heapq.heappop(back)
            waiting.extendleft(reversed(jobs))
            free += [(max(now, since), number) for since, number in idle]
            idle.clear()
            heapq.heapify(free)
            continue
        now, number = heapq.heappop(free)
        if not waiting:
            idle.append((now, number))
            continue
        jobs = [waiting.popleft() for _ in range(piece_size(len(waiting), at_once, workers))]
        pace = trouble.slowness if slow[number] else 1.0
        ends = now + draw.exponential(_HOUR / trouble.lost_per_hour) if trouble.lost_per_hour else float("inf")
        for done, job in enumerate(jobs):
            if now + seconds[job] * pace > ends:
                again, lost = again + ends - now, lost + 1
                heapq.heappush(back, (ends + trouble.found_s, jobs[done:]))
                now = ends + trouble.found_s + trouble.start_s
                break
            now += seconds[job] * pace
            wall = max(wall, now)
        heapq.heappush(free, (now, number))
    return Schedule(workers, wall, float(sum(seconds)), again, lost)
