"""A pool of spawned processes with a time limit for each result, since a process may hang or be stopped.

:func:`open_pool` opens one on this machine, or wherever :func:`pools_from` says.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, TimeoutError
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Final, Protocol, TypeVar

from ucon.core.errors import UconError

T = TypeVar("T")
R = TypeVar("R")
#: Environment of a worker process: workers give the parallelism, and sums must not depend on the number of threads.
ONE_THREAD: Final = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
#: Longest time for one result, seconds.
PATIENCE_S: Final = 3600.0
_TICK_S: Final = 1.0
#: Seconds for a process to end by itself before it is killed.
_END_S: Final = 10.0


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class Needs:
    """Homes and episode sets that work loads by name; sent to processes on other machines."""

    homes: tuple[str, ...] = ()
    episodes: tuple[str, ...] = ()
    """Sets of episodes."""


NOTHING: Final = Needs()


class Workers(Protocol):
    """Processes that do pieces of work, here or elsewhere."""

    def submit(self, work: Callable[..., Any], *given: Any) -> Any:
        """Start a piece of work; see :meth:`Pool.submit`."""
        ...

    def result(self, asked: Any) -> Any:
        """The result of a piece of work; see :meth:`Pool.result`."""
        ...

    def map(self, work: Callable[[T], Any], items: Iterable[T]) -> Iterator[Any]:
        """Results for all items, in order."""
        ...


class Pool:
    """A pool of processes on this machine, used as a context; at its end all processes end."""

    def __init__(
        self,
        workers: int,
        begin: Callable[..., None] | None = None,
        given: tuple[Any, ...] = (),
        *,
        patience_s: float = PATIENCE_S,
    ) -> None:
        """Start the processes.

        Args:
            workers: number of processes.
            begin: called first in each process, with ``given``.
            given: sent to each process once.
            patience_s: longest time for one result, seconds.
        """
        spawn = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(workers, mp_context=spawn, initializer=begin, initargs=given)
        self._workers, self._patience_s = workers, patience_s

    def submit(self, work: Callable[..., R], *given: Any) -> Future[R]:
        """Start a piece of work; pieces begin in the order of submission.

        Args:
            work: a function that can be pickled.
            *given: its arguments.
        """
        return self._pool.submit(work, *given)

    def result(self, asked: Future[R]) -> R:
        """Wait for the result of a piece of work; ask in the order of submission.

        Args:
            asked: what :meth:`submit` returned.

        Raises:
            UconError: there was no result in time; the processes are ended.
        """
        waited = 0.0
        tick = min(_TICK_S, self._patience_s / 4)
        while True:
            begun = time.monotonic()
            try:
                return asked.result(tick)
            except TimeoutError:
                if asked.done():  # finished just now, or the work itself raised TimeoutError
                    return asked.result()
            waited += min(time.monotonic() - begun, 2 * tick)  # not the time in which this process was suspended
            if waited > self._patience_s:
                self.close(at_once=True)
                raise UconError(
                    f"a worker process has not answered for {self._patience_s:g} s: it hangs or is stopped, and was "
                    "ended; finished work is kept and the same command continues"
                )

    def map(self, work: Callable[[T], R], items: Iterable[T]) -> Iterator[R]:
        """Results of ``work`` for all items, in order."""
        asked = deque([self.submit(work, item) for item in items])
        while asked:
            yield self.result(asked.popleft())

    def close(self, *, at_once: bool = False) -> None:
        """End the processes: when they finish their work, or by force after ten seconds.

        Args:
            at_once: by force now.
        """
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


class MakePool(Protocol):
    """A function that opens pools, such as :func:`local_pool`."""

    def __call__(
        self,
        workers: int,
        begin: Callable[..., None] | None,
        given: tuple[Any, ...],
        *,
        patience_s: float,
        needs: Needs,
    ) -> AbstractContextManager[Workers]:
        """Open a pool; the arguments are those of :func:`open_pool`."""
        ...


def local_pool(
    workers: int, begin: Callable[..., None] | None, given: tuple[Any, ...], *, patience_s: float, needs: Needs
) -> AbstractContextManager[Workers]:
    """Open a pool of processes on this machine, where everything in ``needs`` is already present."""
    return Pool(workers, begin, given, patience_s=patience_s)


_make: ContextVar[MakePool] = ContextVar("make_pool", default=local_pool)


def open_pool(
    workers: int,
    begin: Callable[..., None] | None = None,
    given: tuple[Any, ...] = (),
    *,
    patience_s: float = PATIENCE_S,
    needs: Needs = NOTHING,
) -> AbstractContextManager[Workers]:
    """Open a pool of processes on this machine, or, within :func:`pools_from`, one that its ``make`` opens.

    Args:
        workers: number of processes on this machine.
        begin: called first in each process, with ``given``.
        given: sent to each process once.
        patience_s: longest time for one result, seconds.
        needs: what the work loads by name.
    """
    return _make.get()(workers, begin, given, patience_s=patience_s, needs=needs)


@contextmanager
def pools_from(make: MakePool) -> Iterator[None]:
    """Context manager within which :func:`open_pool` opens its pools with ``make``."""
    before = _make.set(make)
    try:
        yield
    finally:
        _make.reset(before)
