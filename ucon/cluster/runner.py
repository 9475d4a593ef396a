"""``runner=ray``: evaluation on a Ray cluster, and a pool of its workers for other work."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from ucon.cluster.connection import cluster_cpus, connect
from ucon.cluster.crew import Crew
from ucon.cluster.luggage import Luggage
from ucon.cluster.pool import RayPool
from ucon.cluster.roles import Playing
from ucon.core.errors import ConfigError, brief
from ucon.core.pool import NOTHING, Needs
from ucon.evaluation.playing.jobs import Job
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec
from ucon.lives.asked import Asked


@dataclass(frozen=True)
class RayRunner:
    """Runs work in Ray actors.

    Raises:
        ConfigError: a number out of range.
    """

    from_command_line: ClassVar = ("address",)
    address: str | None = None
    """``host:port`` of a running cluster, or ``auto``; None: a cluster on this machine, for this command."""
    cpus: float = 1.0
    """CPUs of each worker, which computes with one thread."""
    gpus: float = 0.0
    """GPUs of each worker, for agents that compute there (``agent.device=cuda``)."""

    def __post_init__(self) -> None:
        for name, least in (("cpus", 0.1), ("gpus", 0.0)):
            value = getattr(self, name)
            if type(value) not in (int, float) or not least <= value <= 1024:
                raise ConfigError(f"runner.{name}={brief(value)}: expected a number from {least:g} to 1024")

    def play(self, spec: RunSpec, jobs: Sequence[Job], workers: int | str, timeout_s: float) -> Iterator[PlayedEpisode]:
        """Play jobs on the cluster; yields episodes as they end.

        Args:
            spec: agent, environment, habit level.
            jobs: see :data:`Job`.
            workers: ``auto`` for all CPUs of the cluster, or a number from 1 up.
            timeout_s: most seconds per episode.

        Raises:
            UconError: as :meth:`Crew.receive`.
        """
        if workers != "auto" and not (str(workers).isdecimal() and int(workers) > 0):
            raise ConfigError(f"workers={workers}: with runner=ray expected 'auto', or a number from 1 up")
        if not jobs:
            return
        ray = connect(self.address, None if workers == "auto" else int(workers))
        count = self._members(ray) if workers == "auto" else int(workers)
        luggage = Luggage.packed({_home(job) for _, job in jobs}, here=self.address is None)
        crew = Crew(ray, Playing(spec), count, timeout_s, luggage, cpus=self.cpus, gpus=self.gpus)
        crew.add(jobs)
        try:
            while crew.busy:
                for _, played in crew.receive():
                    yield played
        finally:
            crew.close()

    def pool(
        self,
        workers: int,
        begin: Callable[..., None] | None = None,
        given: tuple[Any, ...] = (),
        *,
        patience_s: float,
        needs: Needs = NOTHING,
    ) -> RayPool:
        """A pool on all CPUs of the cluster; ``workers`` matters only if the cluster is made for this command.

        Args:
            workers: CPUs of a cluster that is made for this command.
            begin: called first in each process, with ``given``.
            given: sent to each process once.
            patience_s: longest time for one result, seconds.
            needs: homes and sets that the work loads.
        """
        ray = connect(self.address, workers)
        luggage = Luggage.packed(needs.homes, needs.episodes, here=self.address is None)
        return RayPool(ray, self._members(ray), begin, given, patience_s, luggage, cpus=self.cpus, gpus=self.gpus)

    def _members(self, ray: Any) -> int:
        return max(1, int(cluster_cpus(ray) / self.cpus))


def _home(job: Any) -> str:
    return str(job.life.scene if isinstance(job, Asked) else job.scene)
