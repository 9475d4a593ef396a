"""A pool of spawned processes whose results are not waited for without end: one may be stopped, and says nothing."""

from __future__ import annotations

import multiprocessing
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, TimeoutError
from types import TracebackType
from typing import Any, Final, TypeVar

from ucon.core.errors import UconError

T = TypeVar("T")
R = TypeVar("R")
#: The longest time that one piece of work may take, in seconds.
PATIENCE_S: Final = 3600.0
_TICK_S: Final = 1.0
#: Seconds in which a process ends that has nothing to do any more.
_END_S: Final = 10.0


class Pool:
    """``with Pool(workers) as pool``: the processes end with it, all of them, whatever they do.

    Args:
        workers: how many.
        begin: called first in each, with ``given``.
        given: sent to each once.
        patience_s: see :meth:`result`.
    """

    def __init__(
        self,
        workers: int,
        begin: Callable[..., None] | None = None,
        given: tuple[Any, ...] = (),
        *,
        patience_s: float = PATIENCE_S,
    ) -> None:
        spawn = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(workers, mp_context=spawn, initializer=begin, initargs=given)
        self._workers, self._patience_s = workers, patience_s

    def submit(self, work: Callable[..., R], *given: Any) -> Future[R]:
        """Have something done; work is begun in the order in which it is asked for."""
        return self._pool.submit(work, *given)

    def result(self, asked: Future[R]) -> R:
        """What came of it. To be asked for in the order in which the work was.

        Raises:
            UconError: nothing came in time: the processes are ended.
        """
        waited = 0.0
        tick = min(_TICK_S, self._patience_s / 4)
        while True:
            begun = time.monotonic()
            try:
                return asked.result(tick)
            except TimeoutError:
                if asked.done():  # just now, or it is an error of the work itself
                    return asked.result()
            waited += min(time.monotonic() - begun, 2 * tick)  # this process may have stood still, by Ctrl-Z
            if waited > self._patience_s:
                self.close(at_once=True)
                raise UconError(
                    f"a worker process has not answered for {self._patience_s:g} s: it hangs or is stopped, and is "
                    "ended; the same command goes on with what is kept"
                )

    def map(self, work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        """Results in order."""
        asked = deque([self.submit(work, item) for item in items])
        while asked:
            yield self.result(asked.popleft())

    def close(self, *, at_once: bool = False) -> None:
        """End the processes: after what they are at, or where that takes long, or ``at_once``, by force."""
        processes = list((self._pool._processes or {}).values())
        if at_once:
            for process in processes:
                process.kill()
        self._pool.shutdown(wait=False, cancel_futures=True)
        deadline = time.monotonic() + _END_S
        for process in processes:
            process.join(max(0.0, deadline - time.monotonic()))
            if process.is_alive():
                process.kill()
                process.join(_END_S)

    def __enter__(self) -> Pool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(at_once=kind is not None)
