"""Gives a learner the replays of its trajectories: from memory, played by worker processes, or played in this process.

Batches come in the order in which they are asked for, with the same content for any number of workers. Replays are
kept compressed until the granted memory is full. None is ever evicted: learners pass over the same trajectories again
and again, and evicting the oldest would make every look-up miss.
"""

from __future__ import annotations

import copy
import multiprocessing
import zlib
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.process import BaseProcess
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from ucon.learning.imitation.trajectories import Replay, Replayer, Trajectory
from ucon.learning.run.workers import WORKER_TIMEOUT_S, ask, begin_worker, lost_worker

if TYPE_CHECKING:
    from torch import nn

    from ucon.learning.policies.action_policy import ActionPolicy

#: Number of batches that workers play ahead of the learner.
_AHEAD: Final = 3
_OPTION: Final = "learner.worker_timeout_s"
_CONTEXT, _FRAMES, _REWARDS = "context/", "frames/", "rewards"

_replayer: Replayer | None = None


class Feeder:
    """Turns batches of trajectories into batches of replays (see the module).

    Args:
        policy: its ``context`` and ``frame`` make the arrays; its frozen networks turn frames into ``features`` once,
            on
            the device of its parameters.
        make_env: makes an environment of ``UcON-v0``; pickled and sent to workers.
        workers: number of processes that play; 0 plays in this one.
        memory_bytes: memory for kept replays, compressed.
        worker_timeout_s: seconds that workers may take for the replay that is needed next.
    """

    def __init__(
        self,
        policy: nn.Module,
        make_env: Callable[[], Any],
        *,
        workers: int = 0,
        memory_bytes: int = 1 << 30,
        worker_timeout_s: float = WORKER_TIMEOUT_S,
    ) -> None:
        self._policy = cast("ActionPolicy", policy)
        self._free_bytes, self._timeout_s = memory_bytes, worker_timeout_s
        self._kept: dict[tuple[str, str, str], bytes] = {}
        self._play = Replayer(self._policy, make_env)
        self._pool: ProcessPoolExecutor | None = None
        self._started: dict[int, BaseProcess] = {}
        """All workers started so far by process id; the pool itself forgets those that died."""
        if workers:
            self._pool = ProcessPoolExecutor(
                workers,
                mp_context=multiprocessing.get_context("spawn"),
                initializer=_begin,
                initargs=(copy.deepcopy(policy).cpu(), make_env),
            )

    def close(self) -> None:
        """Kill the workers, drop what they were asked for, and close the environment.

        Later calls play in this process.
        """
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            for worker in self._workers():
                worker.kill()  # it may be stopped (SIGSTOP); its results are not needed any more
            self._pool = None
        self._play.close()

    def __call__(self, batches: Iterable[Sequence[Trajectory]]) -> Iterator[list[tuple[Trajectory, Replay]]]:
        """Replays of each batch, in order; workers play up to three batches ahead.

        Yields:
            For each batch, its (trajectory, replay) pairs in the batch's order. Frames are features where the policy
            has
            frozen networks.

        Raises:
            LearnerWorkerError: a worker was killed, or did not answer within ``worker_timeout_s``.
            DataError: a trajectory whose actions go on after the episode's end.
        """
        waiting: deque[list[tuple[Trajectory, Future[Replay] | None]]] = deque()
        for batch in batches:
            waiting.append([(trajectory, self._submit(trajectory)) for trajectory in batch])
            if len(waiting) > (_AHEAD if self._pool else 0):
                yield [(trajectory, self._receive(trajectory, played)) for trajectory, played in waiting.popleft()]
        for left in waiting:
            yield [(trajectory, self._receive(trajectory, played)) for trajectory, played in left]

    def _submit(self, trajectory: Trajectory) -> Future[Replay] | None:
        """Submit a trajectory to the workers; None if it is in memory already or there are no workers."""
        if self._pool is None or self._key(trajectory) in self._kept:
            return None
        try:
            asked = self._pool.submit(_work, trajectory)
        except BrokenProcessPool:  # a pool that lost a worker accepts no more jobs
            if lost := lost_worker(self._workers()):
                raise lost from None
            raise
        self._started |= self._pool._processes or {}
        return asked

    def _receive(self, trajectory: Trajectory, played: Future[Replay] | None) -> Replay:
        """The replay from memory, from ``played``, or played now; it is kept if it still fits."""
        key = self._key(trajectory)
        if (packed := self._kept.get(key)) is not None:
            return _unpacked(packed)
        replay = self._with_features(self._play(trajectory) if played is None else self._result_of(played))
        packed = _packed(replay)
        if len(packed) <= self._free_bytes:
            self._free_bytes -= len(packed)
            self._kept[key] = packed
        return replay

    def _result_of(self, played: Future[Replay]) -> Replay:
        """Wait for a replay that a worker was asked for.

        Raises:
            LearnerWorkerError: a worker was killed, or did not answer in time.
        """
        if played.done() and played.exception() is None:
            return played.result()
        return ask(played.result, self._timeout_s, self._workers, _OPTION)

    def _workers(self) -> list[BaseProcess]:
        return list(self._started.values())

    def _key(self, trajectory: Trajectory) -> tuple[str, str, str]:
        """Key of a replay in memory.

        Without the habit level if the policy reads no habits, since its frames are then equal.
        """
        name, level, actions = trajectory.key
        return name, level if self._policy.uses_habits else "", actions

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


def _begin(policy: Any, make_env: Callable[[], Any]) -> None:
    """Initialise a worker: create its replayer."""
    begin_worker()
    global _replayer
    _replayer = Replayer(policy, make_env)


def _work(trajectory: Trajectory) -> Replay:
    """Replay one trajectory in a worker."""
    if _replayer is None:
        raise RuntimeError("a worker without an environment")
    return _replayer(trajectory)


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
