"""Feeds a learner with replays: from memory where they fit, else played again, by worker processes if there are any.

Batches come in the order in which they are asked for and hold the same whatever the number of workers. What was made
is kept, compressed, until the memory that is granted is full; nothing is thrown out for something newer, since learners
go round and round and would find none of it again.
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
from ucon.learning.imitation.workers import WORKER_TIMEOUT_S, ask, begin_worker, lost_one

if TYPE_CHECKING:
    from torch import nn

    from ucon.learning.policies.action_policy import ActionPolicy

#: Batches that workers are ahead of the learner.
_AHEAD: Final = 3
_OPTION: Final = "learner.worker_timeout_s"
_CONTEXT, _FRAMES, _REWARDS = "context/", "frames/", "rewards"

_replayer: Replayer | None = None


class Feeder:
    """See the module.

    Args:
        policy: turns what is seen into arrays; what its frozen networks make of them is computed once, where it is.
        make_env: makes an environment of ``UcON-v0``; sent to workers.
        workers: processes that play; 0 plays in this one.
        memory_bytes: of the replays that are kept.
        worker_timeout_s: so long may what is next take them.
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
        self._room, self._timeout_s = memory_bytes, worker_timeout_s
        self._kept: dict[tuple[str, str, str], bytes] = {}
        self._play = Replayer(self._policy, make_env)
        self._pool: ProcessPoolExecutor | None = None
        self._crew: dict[int, BaseProcess] = {}
        """The workers that were begun so far; a pool forgets those that it lost."""
        if workers:
            self._pool = ProcessPoolExecutor(
                workers,
                mp_context=multiprocessing.get_context("spawn"),
                initializer=_begin,
                initargs=(copy.deepcopy(policy).cpu(), make_env),
            )

    def close(self) -> None:
        """End the workers, without what they were asked for ahead; from then on this process plays."""
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            for worker in self._workers():
                worker.kill()  # it may be stopped, and holds nothing that is worth waiting for
            self._pool = None
        self._play.close()

    def __call__(self, batches: Iterable[Sequence[Trajectory]]) -> Iterator[list[tuple[Trajectory, Replay]]]:
        """Each batch with its replays, one after the other."""
        waiting: deque[list[tuple[Trajectory, Future[Replay] | None]]] = deque()
        for batch in batches:
            waiting.append([(trajectory, self._ask(trajectory)) for trajectory in batch])
            if len(waiting) > (_AHEAD if self._pool else 0):
                yield [(trajectory, self._take(trajectory, played)) for trajectory, played in waiting.popleft()]
        for left in waiting:
            yield [(trajectory, self._take(trajectory, played)) for trajectory, played in left]

    def _ask(self, trajectory: Trajectory) -> Future[Replay] | None:
        """Have it played, unless it is in memory or nobody else can."""
        if self._pool is None or self._key(trajectory) in self._kept:
            return None
        try:
            asked = self._pool.submit(_work, trajectory)
        except BrokenProcessPool:  # one that lost a worker takes no more
            if lost := lost_one(self._workers()):
                raise lost from None
            raise
        self._crew |= self._pool._processes or {}
        return asked

    def _take(self, trajectory: Trajectory, played: Future[Replay] | None) -> Replay:
        key = self._key(trajectory)
        if (packed := self._kept.get(key)) is not None:
            return _unpacked(packed)
        replay = self._with_features(self._play(trajectory) if played is None else self._answer(played))
        packed = _packed(replay)
        if len(packed) <= self._room:
            self._room -= len(packed)
            self._kept[key] = packed
        return replay

    def _answer(self, played: Future[Replay]) -> Replay:
        """What a worker has played.

        Raises:
            WorkerError: one was killed, or none answers in time.
        """
        if played.done() and played.exception() is None:
            return played.result()
        return ask(played.result, self._timeout_s, self._workers, _OPTION)

    def _workers(self) -> list[BaseProcess]:
        return list(self._crew.values())

    def _key(self, trajectory: Trajectory) -> tuple[str, str, str]:
        """Frames of a policy that reads no habits are the same at every level."""
        name, level, actions = trajectory.key
        return name, level if self._policy.uses_habits else "", actions

    def _with_features(self, replay: Replay) -> Replay:
        import torch

        device = next(cast("nn.Module", self._policy).parameters()).device
        frames = {name: torch.from_numpy(array).to(device) for name, array in replay.frames.items()}
        with torch.no_grad():
            made = self._policy.features(frames)
        if made is frames:
            return replay
        return Replay(replay.context, {k: v.cpu().numpy() for k, v in made.items()}, replay.rewards)


def _begin(policy: Any, make_env: Callable[[], Any]) -> None:
    """Give this worker its replayer."""
    begin_worker()
    global _replayer
    _replayer = Replayer(policy, make_env)


def _work(trajectory: Trajectory) -> Replay:
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
