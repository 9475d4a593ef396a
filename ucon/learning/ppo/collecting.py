"""Collects experience for PPO with TorchRL's collectors, in this process or in workers.

Every collection begins with fresh episodes and a given seed, so it depends only on the weights and that seed: where a
worker was lost, all are replaced, and the collection is made again.
"""

from __future__ import annotations

import atexit
import contextlib
import copy
import functools
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from typing import Any, Protocol

# torchrl reads both when it is imported: seconds after which a worker that hangs is an error.
os.environ.setdefault("MAX_IDLE_COUNT", "3600")
os.environ.setdefault("BATCHED_PIPE_TIMEOUT", "3600")

import torch
from tensordict import TensorDictBase
from torch import nn
from torchrl.collectors import Collector, MultiSyncCollector

from ucon.core.errors import ConfigError, brief
from ucon.learning.policies.actor import rollout_actor
from ucon.learning.ppo.rollout_env import rollout_env
from ucon.learning.run.workers import (
    WORKER_TIMEOUT_S,
    LearnerWorkerError,
    Replacements,
    ask,
    begin_worker,
    check_timeout,
)
from ucon.task.episode import Episode

MakeEnv = Callable[[], Any]


class Collecting(Protocol):
    """Which TorchRL collector is used, and with how many environments."""

    rows: int
    """Number of environments that are played at the same time."""
    worker_timeout_s: float
    """Most seconds that one collection may take."""

    def collector(self, make: Callable[[], Any], actor: nn.Module, steps: int, homes: tuple[str, ...]) -> Any:
        """A TorchRL collector; each of its batches begins with a reset.

        Args:
            make: makes an environment.
            actor: the policy as a module over tensordicts.
            steps: of each environment in a batch.
            homes: that the environments load; sent to workers on other machines.
        """
        ...


@dataclass(frozen=True)
class InProcess:
    """Collects in one environment in this process."""

    rows = 1
    worker_timeout_s = WORKER_TIMEOUT_S

    def collector(self, make: Callable[[], Any], actor: nn.Module, steps: int, homes: tuple[str, ...]) -> Any:
        """A collector whose batches are (steps,)."""
        return Collector(make, actor, frames_per_batch=steps, **COLLECTOR_OPTIONS)


@dataclass(frozen=True)
class InWorkers:
    """Collects in one environment in each of ``workers`` processes.

    Workers that take longer than ``worker_timeout_s`` seconds for a collection are replaced, like those that die.

    Raises:
        ConfigError: a number out of range.
    """

    workers: int = 2
    worker_timeout_s: float = WORKER_TIMEOUT_S

    def __post_init__(self) -> None:
        if type(self.workers) is not int or not 1 <= self.workers <= 1024:
            raise ConfigError(
                f"collector.workers={brief(self.workers)}: expected a whole number from 1 to 1024; "
                "collector=in_process plays without workers"
            )
        check_timeout("collector.worker_timeout_s", self.worker_timeout_s)

    @property
    def rows(self) -> int:
        """Number of environments, one per worker."""
        return self.workers

    def collector(self, make: Callable[[], Any], actor: nn.Module, steps: int, homes: tuple[str, ...]) -> Any:
        """A collector whose batches are (workers, steps)."""
        frames = steps * self.workers
        made = [functools.partial(_in_worker, make, os.getpid())] * self.workers
        return MultiSyncCollector(made, actor, frames_per_batch=frames, cat_results="stack", **COLLECTOR_OPTIONS)


def _in_worker(make: Callable[[], Any], trainer: int) -> Any:
    """Make an environment in a worker, which is prepared first."""
    if os.getpid() != trainer:  # TorchRL may make an environment in the trainer's process too
        begin_worker()
    return make()


#: Arguments of every collector. ``compact_obs``: each observation is stored once, which halves the memory.
COLLECTOR_OPTIONS: dict[str, Any] = {
    "total_frames": -1,
    "reset_at_each_iter": True,
    "compact_obs": True,
    "device": torch.device("cpu"),
}


class ExperienceCollector:
    """Collects experience with a copy of the policy on the CPU, whatever device it is trained on.

    Args:
        policy: an :class:`ucon.learning.policies.action_policy.ActionPolicy` that is a torch module; each collection
            uses its present weights.
        make_env: makes an environment; pickled and sent to workers.
        episodes: to draw from.
        levels: habit levels, mixed.
        collecting: which collector.
        steps: of each environment in a collection.
    """

    def __init__(
        self,
        policy: nn.Module,
        make_env: MakeEnv,
        episodes: Sequence[Episode],
        levels: Sequence[str],
        collecting: Collecting,
        steps: int,
    ) -> None:
        self._policy, self._playing = policy, copy.deepcopy(policy).cpu().eval()
        self._playing.requires_grad_(False)
        reader = copy.deepcopy(self._playing)
        make = functools.partial(rollout_env, reader, make_env, tuple(episodes), tuple(levels))
        self.shape = (collecting.rows, steps)
        self._homes = tuple(sorted({episode.scene for episode in episodes}))
        self._collecting, self._make, self._actor = collecting, make, rollout_actor(self._playing)
        self._collector: Any = None
        self._batches: Iterator[TensorDictBase] | None = None
        self._replaced = Replacements()

    def collect(self, seed: int) -> TensorDictBase:
        """Play one collection with the policy's present weights.

        Args:
            seed: below 2 ** 63; with the weights it decides everything that is played.

        Returns:
            (rows, steps) tensordict on the CPU.

        Raises:
            LearnerWorkerError: a worker died, or the collection took too long, and workers were replaced too often.
        """
        while True:
            try:
                return self._collect(seed)
            except LearnerWorkerError as lost:
                self.close()
                self._replaced.count(lost)

    def _collect(self, seed: int) -> TensorDictBase:
        """Play one collection, with new workers where there are none."""
        if self._batches is None:
            self._collector = self._collecting.collector(self._make, self._actor, self.shape[1], self._homes)
            self._batches = iter(self._collector)
            atexit.register(self.close)  # else Python would wait at exit for the workers
        self._playing.load_state_dict(self._policy.state_dict())
        # The present ones: a thread that was abandoned must not ask the workers of a later collection.
        question = functools.partial(self._collected, self._collector, self._batches, seed)
        try:
            return ask(question, self._collecting.worker_timeout_s, self._workers, "collector.worker_timeout_s")
        except BaseException:
            self._kill()
            raise

    def _collected(self, collector: Any, batches: Iterator[TensorDictBase], seed: int) -> TensorDictBase:
        """Update the weights, set the seeds and take the next batch."""
        collector.update_policy_weights_()
        collector.set_seed(seed % (1 << 31))
        torch.manual_seed(seed)
        return next(batches).reshape(self.shape)

    def _workers(self) -> list[BaseProcess]:
        return list(getattr(self._collector, "procs", ()))

    def _kill(self) -> None:
        """Kill workers in the middle of a collection that is no longer needed: closing would wait for its end."""
        for worker in self._workers():
            with contextlib.suppress(ValueError):  # it was closed
                worker.kill()

    def close(self) -> None:
        """End the workers; a later collection starts new ones."""
        if self._collector is not None:
            atexit.unregister(self.close)
            self._collector.shutdown(raise_on_error=False)  # workers may be gone already
            self._collector = self._batches = None
