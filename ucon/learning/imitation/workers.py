"""Processes that work for a learner: one thread each, none outlives it, and none is waited for for ever."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from multiprocessing.process import BaseProcess
from typing import Final, TypeVar

from ucon.core.errors import ConfigError, UconError, brief
from ucon.core.memory import keep_freed_memory

#: So long may workers take for what one step asks of them, unless another limit is given.
WORKER_TIMEOUT_S: Final = 3600.0
#: So long is waited for the exit code of a worker that is gone, and until whoever waits for it notices.
_JOIN_S, _GRACE_S = 5.0, 5.0
#: How often is looked after the workers while they work.
_TICK_S: Final = 0.5
_KEPT: Final = "what is saved is kept: resume=RUN goes on"
#: More processes than any machine has use for.
MOST_WORKERS: Final = 1024
#: What threads can wait for.
_MOST_S: Final = 1e6

T = TypeVar("T")


class LearnerWorkerError(UconError):
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


def ask(question: Callable[[], T], seconds: float, workers: Callable[[], Sequence[BaseProcess]], option: str) -> T:
    """What comes of a question to workers; they are ended where it takes longer than a limit.

    It is asked in a thread, which is left behind where it waits for ever: libraries do, for workers that are gone.

    Args:
        question: waits for the answer.
        seconds: the limit.
        workers: those who are asked; where there are none, the answer is made here.
        option: what gives them more time.

    Raises:
        WorkerError: naming those who did not answer in time, or are gone. What a worker raised itself passes.
    """
    asked = list(workers())
    if not asked:
        return question()
    answer: Future[T] = Future()
    threading.Thread(target=_answer, args=(question, answer), daemon=True).start()
    limit, gone_since = time.monotonic() + seconds, None
    while not wait([answer], timeout=_TICK_S).done:
        now = time.monotonic()
        if now > limit:
            raise lost_one(asked) or _late(asked, seconds, option)
        if any(_code(worker) is not None for worker in asked):
            gone_since = gone_since or now
            if now > gone_since + _GRACE_S:  # whoever waits has not noticed
                break
    error = answer.exception() if answer.done() else None
    if answer.done() and error is None:
        return answer.result()
    if lost := lost_one(asked, killed_only=error is not None):
        raise lost from None
    return answer.result(timeout=0)


def _answer(question: Callable[[], T], answer: Future[T]) -> None:
    try:
        answer.set_result(question())
    except BaseException as error:  # of whoever asked
        answer.set_exception(error)


def _late(asked: Sequence[BaseProcess], seconds: float, option: str) -> LearnerWorkerError:
    """End those who were asked."""
    alive = [worker for worker in asked if _code(worker) is None]
    names = ", ".join(_names(alive or asked))
    for worker in alive:
        worker.kill()
    return LearnerWorkerError(
        f"{names}: no answer within {seconds:g} s, so the workers were ended; {_KEPT}, {option} gives them more time"
    )


def lost_one(asked: Sequence[BaseProcess], *, killed_only: bool = True) -> LearnerWorkerError | None:
    """What to raise where a worker is gone; None where none is, or where one ended by itself and has said why."""
    codes = {worker: _code(worker, _JOIN_S) for worker in asked}
    gone = [worker for worker, code in codes.items() if code is not None and (code < 0 or not killed_only)]
    # Where one is lost, others are sent home.
    first = next((worker for worker in gone if codes[worker] != -signal.SIGTERM), gone[0] if gone else None)
    if first is None:
        return None
    code = codes[first] or 0
    how = f"killed by signal {-code}, as where memory runs out" if code < 0 else f"ended with code {code}"
    return LearnerWorkerError(f"{_names([first])[0]}: {how}; {_KEPT}")


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
