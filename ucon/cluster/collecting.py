"""``collector=ray``: experience for PPO from TorchRL's ``RayCollector``, whose workers are replaced when they are lost.

A collection depends on weights and seed alone, so it is repeated if a worker is lost during it.
"""

from __future__ import annotations

import contextlib
import functools
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as LimitReached
from dataclasses import dataclass
from typing import Any, ClassVar, Final, TypeVar

import numpy as np
import torch
from tensordict import TensorDictBase
from torch import Tensor, nn
from torchrl.collectors import Collector

from ucon.cluster.connection import connect
from ucon.cluster.luggage import Luggage
from ucon.core.errors import ConfigError, brief
from ucon.evaluation.playing.crew import TRIES
from ucon.learning.ppo.collecting import COLLECTOR_OPTIONS
from ucon.learning.run.workers import WORKER_TIMEOUT_S, LearnerWorkerError, check_timeout

T = TypeVar("T")
#: Seconds that workers have to answer a ping, after a collection took too long.
_PING_S: Final = 10.0
#: Seconds within which workers have to be placed and started.
_START_S: Final = 600.0


@dataclass(frozen=True)
class OnRay:
    """Collects in one environment in each of ``workers`` Ray actors.

    Raises:
        ConfigError: a number out of range.
    """

    from_command_line: ClassVar = ("address",)
    workers: int = 2
    address: str | None = None
    """``host:port`` of a running cluster, or ``auto``; None: a cluster on this machine, for this command."""
    worker_timeout_s: float = WORKER_TIMEOUT_S
    """Most seconds of one collection."""

    def __post_init__(self) -> None:
        if type(self.workers) is not int or not 1 <= self.workers <= 100_000:
            raise ConfigError(f"collector.workers={brief(self.workers)}: expected a whole number from 1 to 100000")
        check_timeout("collector.worker_timeout_s", self.worker_timeout_s)

    @property
    def rows(self) -> int:
        """Number of environments, one per worker."""
        return self.workers

    def collector(self, make: Callable[[], Any], actor: nn.Module, steps: int, homes: tuple[str, ...]) -> Any:
        """A collector whose batches are (workers, steps).

        Args:
            make: makes an environment.
            actor: the policy as a module over tensordicts.
            steps: of each environment in a batch.
            homes: names of the homes that the environments load.
        """
        ray = connect(self.address, self.workers)
        made = functools.partial(_with_luggage, ray.put(Luggage.packed(homes, here=self.address is None)), make)
        return _LastingCollector(ray, self, made, actor, steps)


def _with_luggage(luggage: Any, make: Callable[[], Any]) -> Any:
    """In an actor, unpack the luggage and then make an environment."""
    import ray

    torch.set_num_threads(1)
    ray.get(luggage).unpack()
    return make()


class _RemoteCollector(Collector):
    """The collector in an actor; it is given weights and a seed for each collection.

    TorchRL sends weights to actors through a store of ``torch.distributed``, which waits a minute for a lost actor.
    Sending them as Ray objects is as fast.
    """

    def take(self, weights: Mapping[str, Tensor], seed: int) -> int:
        """Take the policy's weights and seed; returns the seed of the next actor."""
        self.policy.load_state_dict(weights)
        return self.set_seed(seed)

    def set_seed(self, seed: int, static_seed: bool = False) -> int:
        """Seed the environments and the drawing of actions, as TorchRL's collectors in processes do."""
        following: int = super().set_seed(seed, static_seed)
        torch.manual_seed(seed)
        np.random.seed(seed)  # noqa: NPY002 (the libraries' global state)
        self.reset()  # draws one more episode, as those collectors do
        return following


class _LastingCollector:
    """A ``RayCollector`` that is replaced by a new one if a worker dies or hangs.

    Args:
        ray: the module, connected.
        options: of the collector.
        make: makes an environment.
        actor: the policy as a module over tensordicts.
        steps: of each environment in a batch.
    """

    def __init__(self, ray: Any, options: OnRay, make: Callable[[], Any], actor: nn.Module, steps: int) -> None:
        self._ray, self._options, self._make, self._actor, self._steps = ray, options, make, actor, steps
        self._seed = 0
        self._collector: Any = None

    def update_policy_weights_(self) -> None:
        """Do nothing: every collection begins by sending the actor's present weights."""

    def set_seed(self, seed: int) -> None:
        """Set the seed of the next collection."""
        self._seed = seed

    def __iter__(self) -> Iterator[TensorDictBase]:
        """Collections, each with the actor's present weights and the seed that was set last."""
        while True:
            yield self._collected()

    def shutdown(self, *, raise_on_error: bool = True) -> None:
        """End the workers; a later collection starts new ones."""
        lost, self._collector = self._collector, None
        if lost is not None and self._ray.is_initialized():  # else they ended with the connection
            with contextlib.suppress(self._ray.exceptions.RayError):  # some may be gone
                lost.shutdown()

    def _collected(self) -> TensorDictBase:
        """One collection, repeated with new workers if some were lost.

        Raises:
            LearnerWorkerError: workers were lost each time.
        """
        for _ in range(TRIES):
            try:
                if self._collector is None:
                    within(_START_S, self._start)
                return within(self._options.worker_timeout_s, self._collect)
            except self._ray.exceptions.RayTaskError:
                raise  # an error of the environment or the policy
            except self._ray.exceptions.RayError as error:
                lost = f"a worker died ({str(error).strip().splitlines()[-1].strip()[:200]})"
            except LimitReached:
                lost = self._late()
            self.shutdown()
            sys.stderr.write(f"warning: {lost}; the workers are replaced and the collection is repeated\n")
        raise LearnerWorkerError(
            f"{lost}, {TRIES} times in a row; what is saved is kept: resume=RUN continues, "
            "collector.worker_timeout_s gives workers more time"
        )

    def _collect(self) -> TensorDictBase:
        weights, seed = self._ray.put(self._actor.state_dict()), self._seed
        for worker in self._collector.remote_collectors:
            seed = worker.take.remote(weights, seed)  # a reference: Ray passes its value on to the next worker
        return torch.stack(self._ray.get([worker.next.remote() for worker in self._collector.remote_collectors]))

    def _start(self) -> None:
        """Start the workers, and wait until they are ready."""
        self._collector = self._made()
        self._ray.get([worker.__ray_ready__.remote() for worker in self._collector.remote_collectors])

    def _made(self) -> Any:
        from torchrl.collectors.distributed import RayCollector

        number = self._options.workers
        options = dict(COLLECTOR_OPTIONS)
        device = options.pop("device")
        return RayCollector(
            [self._make] * number,
            self._actor,
            frames_per_batch=self._steps * number,
            total_frames=options.pop("total_frames"),
            reset_at_each_iter=options.pop("reset_at_each_iter"),
            collector_kwargs=options,
            num_collectors=number,
            sync=True,
            weight_sync_schemes={},
            collector_class=_RemoteCollector,
            device=device,
            remote_configs={"num_cpus": 1, "num_gpus": 0},
        )

    def _late(self) -> str:
        """A message that names the workers that do not answer."""
        asked = {worker.__ray_ready__.remote(): k for k, worker in enumerate(self._workers())}
        _, late = self._ray.wait(list(asked), num_returns=len(asked), timeout=_PING_S) if asked else ([], [])
        names = ", ".join(f"worker {asked[one]}" for one in late) or "the workers"
        return f"{names} did not answer within {self._options.worker_timeout_s:g} s"

    def _workers(self) -> list[Any]:
        return [] if self._collector is None else list(self._collector.remote_collectors)


def within(seconds: float, question: Callable[[], T]) -> T:
    """Call ``question`` in a separate thread and return its answer; the thread is abandoned if it takes too long.

    Args:
        seconds: the time limit.
        question: waits for others, and returns their answer.

    Raises:
        concurrent.futures.TimeoutError: it took longer. Errors of ``question`` itself pass through.
    """
    answer: Future[T] = Future()

    def ask() -> None:
        try:
            answer.set_result(question())
        except BaseException as error:  # raised again in the thread that waits
            answer.set_exception(error)

    threading.Thread(target=ask, daemon=True).start()
    return answer.result(seconds)
