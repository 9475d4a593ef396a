"""Processes that work for a learner: one thread each, none outlives it, and none is waited for for ever."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Final

from ucon.core.errors import ConfigError, UconError, brief
from ucon.core.memory import keep_freed_memory

#: So long may workers take for what one step asks of them, unless another limit is given.
WORKER_TIMEOUT_S: Final = 3600.0
#: So long is waited for the exit code of a worker that is gone.
_JOIN_S: Final = 5.0
#: What threads can wait for.
_MOST_S: Final = 1e6


class WorkerError(UconError):
    """A worker was killed, or does not answer."""


def begin_worker() -> None:
    """To be called first in a worker. It leaves Ctrl-C to the learner, and ends when the learner is killed."""
    import torch

    torch.set_num_threads(1)
    keep_freed_memory()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)


def check_timeout(option: str, value: object) -> None:
    """Refuse what is no time.

    Raises:
        ConfigError: naming the option.
    """
    if type(value) not in (int, float) or not 0 < value <= _MOST_S:  # type: ignore[operator]
        raise ConfigError(f"{option}={brief(value)}: expected seconds, above 0 and at most {_MOST_S:g}")


@contextmanager
def answered_within(seconds: float, workers: Callable[[], Sequence[BaseProcess]], option: str) -> Iterator[None]:
    """What is asked of workers inside comes within a limit, or they are ended and the wait for them with them.

    Args:
        seconds: the limit.
        workers: those who are asked.
        option: what gives them more time.

    Raises:
        WorkerError: naming those who did not answer in time, or were killed. What a worker raised itself passes.
    """
    late: list[str] = []

    def end() -> None:
        alive = [worker for worker in workers() if _code(worker) is None]
        late.extend(_names(alive))
        for worker in alive:
            worker.kill()  # whoever waits for them learns that they are gone

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    asked = list(workers())
    try:
        yield
    except Exception:
        if late:
            raise WorkerError(
                f"{', '.join(late)}: no answer within {seconds:g} s, so they were ended; what is saved is kept: "
                f"resume=RUN goes on, {option} gives them more time"
            ) from None
        codes = {worker: _code(worker, _JOIN_S) or 0 for worker in asked}
        killed = [worker for worker, code in codes.items() if code < 0]
        # Where one is lost, the others are sent home.
        if first := [worker for worker in killed if codes[worker] != -signal.SIGTERM] or killed:
            raise WorkerError(
                f"{', '.join(_names(first))}: killed by signal {-codes[first[0]]}, as where memory runs out; what is "
                "saved is kept: resume=RUN goes on"
            ) from None
        raise
    finally:
        timer.cancel()


def _code(worker: BaseProcess, wait_s: float = 0.0) -> int | None:
    """Exit code; None while it works."""
    try:
        if not worker.is_alive():
            worker.join(wait_s)
        return worker.exitcode
    except ValueError:  # somebody has closed the handle
        return 0


def _names(workers: Sequence[BaseProcess]) -> list[str]:
    """Workers in words; those that are stopped alone, where the system tells which are."""
    stopped = [worker for worker in workers if _is_stopped(worker.pid)]
    return [f"worker {worker.name} (process {worker.pid})" for worker in stopped or workers]


def _is_stopped(pid: int | None) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:  # noqa: PTH123 (no path of ours)
            return file.read().rpartition(")")[2].split()[0] in ("T", "t")
    except (OSError, IndexError):
        return False
