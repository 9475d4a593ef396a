"""Gives a learner the replays of its trajectories: from memory, played by worker processes, or played in this process.

Batches come in the order in which they are asked for, with the same content for any number of workers. Replays are
kept compressed until the granted memory is full. None is ever evicted: learners pass over the same trajectories again
and again, and evicting the oldest would make every look-up miss.

What a worker plays depends only on what it was asked for. So if one is lost, all are replaced, and the pieces of work
that are not done are asked for again.
"""

from __future__ import annotations

import copy
import multiprocessing
import time
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from multiprocessing.process import BaseProcess
from typing import TYPE_CHECKING, Any, Final, Protocol, cast
from weakref import WeakValueDictionary

import numpy as np

from ucon.learning.imitation.demonstrators import Demonstrator
from ucon.learning.imitation.kept_demonstrations import KeptDemonstrations
from ucon.learning.imitation.replaying import Replayer
from ucon.learning.imitation.trajectories import Replay, Trajectory
from ucon.learning.policies.playing import Job
from ucon.learning.run.workers import (
    WORKER_TIMEOUT_S,
    LearnerWorkerError,
    Replacements,
    ask,
    begin_worker,
    lost_worker,
)

if TYPE_CHECKING:
    from torch import nn

    from ucon.learning.policies.action_policy import ActionPolicy

#: Number of batches that workers play ahead of the learner.
_AHEAD: Final = 3
_OPTION: Final = "learner.worker_timeout_s"
_CONTEXT, _FRAMES, _REWARDS = "context/", "frames/", "rewards"

Played = tuple[Trajectory, Replay]


class Collector(Protocol):
    """Plays parts of a collection, and whole trajectories again."""

    replayer: Replayer

    def __call__(self, part: Any) -> Sequence[Played]:
        """Play a part of a collection: for each of its episodes, the trajectory and what the policy saw."""
        ...

    def close(self) -> None:
        """Close the environments; a later call makes new ones."""
        ...


_replayer: Replayer | None = None
#: How often a dead worker is looked for, and seconds between two looks.
_LOOKS, _LOOK_S = 20, 0.05
_demonstrator: Demonstrator | None = None
_collector: Collector | None = None


@dataclass(eq=False)
class _Asked:
    """A piece of work that a worker was asked for."""

    work: Callable[[Any], Any]
    item: Any
    answer: Future[Any]

    @property
    def lost(self) -> bool:
        """Whether no worker will do it any more, or none has done it yet."""
        if not self.answer.done() or self.answer.cancelled():  # cancelled: not begun when its pool was ended
            return True
        return isinstance(self.answer.exception(), BrokenProcessPool)


class Feeder:
    """Turns batches of trajectories into batches of replays (see the module).

    Args:
        policy: its ``context`` and ``frame`` make the arrays; its frozen networks turn frames into ``features`` once,
            on the device of its parameters.
        make_env: makes an environment of ``UcON-v0``; pickled and sent to workers.
        workers: number of processes that play; 0 plays in this one.
        demonstrator: plays the demonstrations of jobs, in the processes that play the replays, each only once.
        collector: plays parts of collections, in the same processes.
        memory_bytes: memory for kept replays, compressed.
        worker_timeout_s: seconds that workers may take for the replay that is needed next.
    """

    def __init__(
        self,
        policy: nn.Module,
        make_env: Callable[[], Any],
        *,
        demonstrator: Demonstrator | None = None,
        collector: Collector | None = None,
        workers: int = 0,
        memory_bytes: int = 1 << 30,
        worker_timeout_s: float = WORKER_TIMEOUT_S,
    ) -> None:
        self._policy = cast("ActionPolicy", policy)
        self._free_bytes, self._timeout_s = memory_bytes, worker_timeout_s
        self._kept: dict[tuple[str, ...], bytes] = {}
        self._nothing_frozen = False
        """Whether the policy is known to have no frozen networks."""
        self._play = _replayer_of(policy, make_env, collector)
        self._demonstrator, self._collector = demonstrator, collector
        self._pool: ProcessPoolExecutor | None = None
        self._started: dict[int, BaseProcess] = {}
        """All workers started so far by process id; the pool itself forgets those that died."""
        self._open: WeakValueDictionary[int, _Asked] = WeakValueDictionary()
        """Requests to workers whose answers are still awaited, by a running number."""
        self._numbers = count()
        self._replaced = Replacements()
        self._n_workers = workers
        if workers:
            self._given = (copy.deepcopy(policy).cpu(), make_env, demonstrator, collector)
            self._pool = self._made_pool()

    def _made_pool(self) -> ProcessPoolExecutor:
        spawn = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self._n_workers, mp_context=spawn, initializer=_begin, initargs=self._given)

    def close(self) -> None:
        """Kill the workers, drop what they were asked for, and close the environment.

        Later calls play in this process.
        """
        self._open.clear()
        if self._pool is not None:
            self._end_workers(self._pool)
            self._pool = None
        self._play.close()
        for player in (self._demonstrator, self._collector):
            if player is not None:
                player.close()

    def _end_workers(self, pool: ProcessPoolExecutor) -> None:
        """Kill the workers: they may be stopped (SIGSTOP), and what they are doing is no longer needed."""
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in self._workers():
            worker.kill()
        self._started = {}

    def forget(self) -> None:
        """Drop all replays that are kept in memory."""
        self._free_bytes += sum(map(len, self._kept.values()))
        self._kept.clear()

    def begin_collecting(self, parts: Sequence[Any]) -> list[Callable[[], list[Trajectory]]]:
        """Have the workers play parts of a collection while the learner continues.

        Returns:
            For each part, a function that waits for it, keeps its replays while there is memory, and returns its
            trajectories. Without workers it plays the part itself.
        """
        return [self._collecting(part) for part in parts]

    def _collecting(self, part: Any) -> Callable[[], list[Trajectory]]:
        assert self._collector is not None
        asked = None if self._pool is None else self._submitted(_collect, part)

        def collected() -> list[Trajectory]:
            if asked is None:
                assert self._collector is not None
                found = [(one, _packed(replay)) for one, replay in self._collector(part)]
            else:
                found = self._result_of(asked)
            for trajectory, packed in found:
                self._keep(trajectory, self._packed_with_features(packed))
            return [trajectory for trajectory, _ in found]

        return collected

    @cached_property
    def _shown(self) -> KeptDemonstrations:
        """Demonstrations that were played already."""
        if self._demonstrator is None:
            raise RuntimeError("a job without a demonstrator")
        return KeptDemonstrations(self._demonstrator)

    def __call__(self, batches: Iterable[Sequence[Trajectory | Job]]) -> Iterator[list[tuple[Trajectory, Replay]]]:
        """Replays of each batch, in order; workers play up to three batches ahead. Jobs are demonstrated first.

        Yields:
            For each batch, its (trajectory, replay) pairs in the batch's order. Frames are features where the policy
            has frozen networks.

        Raises:
            LearnerWorkerError: a worker was killed, or did not answer within ``worker_timeout_s``, and workers were
                replaced too often.
            DataError: a trajectory whose actions continue after the episode's end.
        """
        waiting: deque[list[tuple[Trajectory | Job, _Asked | None]]] = deque()
        for batch in batches:
            waiting.append([self._submit(item) for item in batch])
            if len(waiting) > (_AHEAD if self._pool else 0):
                yield [self._receive(item, played) for item, played in waiting.popleft()]
        for left in waiting:
            yield [self._receive(item, played) for item, played in left]

    def _submit(self, item: Trajectory | Job) -> tuple[Trajectory | Job, _Asked | None]:
        """Submit what is not in memory to the workers, if there are any; known demonstrations replace their jobs."""
        if isinstance(item, Job):
            item = self._shown.get(item) or item
        if self._pool is None or (isinstance(item, Trajectory) and self._key(item) in self._kept):
            return item, None
        return item, self._submitted(_work, item)

    def _submitted(self, work: Callable[[Any], Any], item: Any) -> _Asked:
        """Have a worker call ``work(item)``."""
        while True:
            try:
                asked = _Asked(work, item, self._answer(work, item))
            except BrokenProcessPool:  # a pool that lost a worker accepts no more jobs
                self._replace(self._lost())
                continue
            self._open[next(self._numbers)] = asked
            return asked

    def _answer(self, work: Callable[[Any], Any], item: Any) -> Future[Any]:
        """Submit ``work(item)`` to the pool; returns the future with the answer."""
        assert self._pool is not None
        answer = self._pool.submit(work, item)
        self._started |= self._pool._processes or {}
        return answer

    def _lost(self) -> LearnerWorkerError:
        """The error that names the worker whose death broke the pool.

        The pool's own thread also waits for dead workers, and until it has noted how one ended, that worker looks
        alive; so this looks several times.
        """
        for _ in range(_LOOKS):
            if (lost := lost_worker(self._workers(), killed_only=False)) is not None:
                return lost
            time.sleep(_LOOK_S)
        return LearnerWorkerError("a worker of unknown number died; what is saved is kept: resume=RUN continues")

    def _replace(self, lost: LearnerWorkerError) -> None:
        """Start new workers, and ask them for everything that is not done.

        Raises:
            LearnerWorkerError: ``lost``, where they were replaced too often.
        """
        assert self._pool is not None
        self._end_workers(self._pool)
        self._replaced.count(lost)
        self._pool = self._made_pool()
        for _, asked in sorted(self._open.items()):
            if asked.lost:
                asked.answer = self._answer(asked.work, asked.item)

    def _receive(self, item: Trajectory | Job, asked: _Asked | None) -> tuple[Trajectory, Replay]:
        """A trajectory and its replay, from memory, from ``asked``, or played now; kept if it still fits."""
        if isinstance(item, Trajectory) and (kept := self._kept.get(self._key(item))) is not None:
            return item, _unpacked(kept)
        played = _played(item, self._demonstrator, self._play) if asked is None else self._result_of(asked)
        trajectory, replay = played[0], self._with_features(played[1])
        if isinstance(item, Job):
            self._shown.keep(item, trajectory)
        if self._free_bytes > 0:
            self._keep(trajectory, _packed(replay))
        return trajectory, replay

    def _keep(self, trajectory: Trajectory, packed: bytes) -> None:
        """Keep a replay, if it still fits."""
        key = self._key(trajectory)
        if key not in self._kept and len(packed) <= self._free_bytes:
            self._free_bytes -= len(packed)
            self._kept[key] = packed

    def _result_of(self, asked: _Asked) -> Any:
        """Wait for what a worker was asked for.

        Raises:
            LearnerWorkerError: a worker was killed, or did not answer in time, and workers were replaced too often.
        """
        while asked.lost:
            try:
                ask(asked.answer.result, self._timeout_s, self._workers, _OPTION)
            except BrokenProcessPool:
                self._replace(self._lost())
            except LearnerWorkerError as lost:
                self._replace(lost)
        return asked.answer.result()

    def _workers(self) -> list[BaseProcess]:
        return list(self._started.values())

    def _key(self, trajectory: Trajectory) -> tuple[str, ...]:
        """Key of a replay in memory.

        Without the habit level if the policy reads no habits, since its frames are then equal.
        """
        name, level, *actions = trajectory.key
        return name, level if self._policy.uses_habits else "", *actions

    def _with_features(self, replay: Replay) -> Replay:
        """The replay with its frames turned into features by the policy's frozen networks, back on the CPU."""
        import torch

        device = next(cast("nn.Module", self._policy).parameters()).device
        frames = {name: torch.from_numpy(array).to(device) for name, array in replay.frames.items()}
        with torch.no_grad():
            made = self._policy.features(frames)
        if made is frames:
            return replay
        return Replay(replay.context, {k: v.cpu().numpy() for k, v in made.items()}, replay.rewards)

    def _packed_with_features(self, packed: bytes) -> bytes:
        """As :meth:`_with_features`, compressed before and after; passed through where no network is frozen."""
        if self._nothing_frozen:
            return packed
        replay = _unpacked(packed)
        made = self._with_features(replay)
        self._nothing_frozen = made is replay
        return packed if self._nothing_frozen else _packed(made)


def _begin(
    policy: Any, make_env: Callable[[], Any], demonstrator: Demonstrator | None, collector: Collector | None
) -> None:
    """Initialise a worker: create its replayer."""
    begin_worker()
    global _replayer, _demonstrator, _collector
    _replayer, _demonstrator, _collector = _replayer_of(policy, make_env, collector), demonstrator, collector


def _replayer_of(policy: Any, make_env: Callable[[], Any], collector: Collector | None) -> Replayer:
    """The collector's replayer, whose expert labels views again; without a collector, one that has no expert."""
    return Replayer(policy, make_env) if collector is None else collector.replayer


def _collect(part: Any) -> list[tuple[Trajectory, bytes]]:
    """Play a part of a collection in a worker; its replays are compressed."""
    if _collector is None:
        raise RuntimeError("a worker without a collector")
    return [(trajectory, _packed(replay)) for trajectory, replay in _collector(part)]


def _work(item: Trajectory | Job) -> Played:
    """Replay one trajectory in a worker, or the demonstration of a job."""
    if _replayer is None:
        raise RuntimeError("a worker without an environment")
    return _played(item, _demonstrator, _replayer)


def _played(item: Trajectory | Job, demonstrator: Demonstrator | None, replayer: Replayer) -> Played:
    """A trajectory and its replay; jobs are demonstrated first."""
    if isinstance(item, Job):
        assert demonstrator is not None
        item = demonstrator(item.episode, item.level)
    return item, replayer(item)


def _packed(replay: Replay) -> bytes:
    from safetensors.numpy import save

    arrays = {f"{_CONTEXT}{name}": value for name, value in replay.context.items()}
    arrays |= {f"{_FRAMES}{name}": value for name, value in replay.frames.items()} | {_REWARDS: replay.rewards}
    return zlib.compress(save({name: np.asarray(value, order="C") for name, value in arrays.items()}), 1)


def _unpacked(packed: bytes) -> Replay:
    from safetensors.numpy import load

    arrays = load(zlib.decompress(packed))
    context, frames = (
        {name.removeprefix(kind): value for name, value in arrays.items() if name.startswith(kind)}
        for kind in (_CONTEXT, _FRAMES)
    )
    return Replay(context, frames, arrays[_REWARDS])
