"""Worker processes of learners: one thread each, ended with the learner, and waited for no longer than a limit."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from multiprocessing.process import BaseProcess
from typing import Final, TypeVar

from ucon.core.errors import ConfigError, UconError, brief
from ucon.core.memory import keep_freed_memory

#: Default limit, in seconds, for what one step asks of the workers.
WORKER_TIMEOUT_S: Final = 3600.0
#: Seconds to wait for the exit code of a dead worker, and for the waiting library to notice that it died.
_JOIN_S, _GRACE_S = 5.0, 5.0
#: Seconds between looks at the workers while they work.
_TICK_S: Final = 0.5
_KEPT: Final = "what is saved is kept: resume=RUN continues"
#: Highest permitted number of workers.
MOST_WORKERS: Final = 1024
#: Longest permitted limit in seconds; threads cannot wait much longer.
_MOST_S: Final = 1e6

#: How often the workers of a run are replaced; if they are lost more often, the problem does not go away.
MOST_REPLACED: Final = 3

T = TypeVar("T")


class LearnerWorkerError(UconError):
    """A worker was killed, ended, or did not answer in time."""


class Replacements:
    """Counts how often the workers of a run were replaced, and reports each time."""

    def __init__(self) -> None:
        self.made = 0

    def count(self, lost: LearnerWorkerError) -> None:
        """Say in a line which worker was lost and that it is replaced.

        Args:
            lost: what happened to it.

        Raises:
            LearnerWorkerError: ``lost``, where workers were replaced :data:`MOST_REPLACED` times already.
        """
        what, then, advice = str(lost).partition(f"; {_KEPT}")
        if self.made >= MOST_REPLACED:
            again = f", after workers were replaced {self.made} times" if self.made else ""
            raise LearnerWorkerError(f"{what}{again}{then}{advice}") from None
        self.made += 1
        sys.stderr.write(
            f"warning: {what}; the workers are replaced ({self.made} of at most {MOST_REPLACED} times), "
            "and their unfinished work is done again\n"
        )


def begin_worker() -> None:
    """Prepare a worker process; has to be called first in it.

    It uses one thread, ignores Ctrl-C (the learner handles it), and exits when the learner dies.
    """
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
    """Refuse a limit that is no number of seconds.

    Args:
        option: name of the option, for the message.
        value: above 0 and at most 1e6.

    Raises:
        ConfigError: naming the option.
    """
    if type(value) not in (int, float) or not 0 < value <= _MOST_S:  # type: ignore[operator]
        raise ConfigError(f"{option}={brief(value)}: expected seconds, above 0 and at most {_MOST_S:g}")


def ask(question: Callable[[], T], seconds: float, workers: Callable[[], Sequence[BaseProcess]], option: str) -> T:
    """Call ``question``, which waits for workers, with a time limit; kill the workers where it takes longer.

    The call runs in a separate thread. That thread is abandoned if the call never returns, as happens in libraries
    whose workers have died.

    Args:
        question: waits for the workers and returns their answer.
        seconds: the limit.
        workers: the processes that are asked; where there are none, ``question`` is called directly.
        option: name of the option that raises the limit, for the message.

    Raises:
        LearnerWorkerError: naming workers that died or did not answer in time. Errors of ``question`` itself pass
            through.
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
            raise lost_worker(asked) or _late(asked, seconds, option)
        if any(_code(worker) is not None for worker in asked):
            gone_since = gone_since or now
            if now > gone_since + _GRACE_S:  # the library has not noticed that a worker died
                break
    error = answer.exception() if answer.done() else None
    if answer.done() and error is None:
        return answer.result()
    if lost := lost_worker(asked, killed_only=error is not None):
        raise lost from None
    return answer.result(timeout=0)


def _answer(question: Callable[[], T], answer: Future[T]) -> None:
    """Call ``question`` and store its result or error in ``answer``."""
    try:
        answer.set_result(question())
    except BaseException as error:  # raised again in the thread that waits
        answer.set_exception(error)


def _late(asked: Sequence[BaseProcess], seconds: float, option: str) -> LearnerWorkerError:
    """Kill the workers that are still alive, and return the error that names them."""
    alive = [worker for worker in asked if _code(worker) is None]
    names = ", ".join(_names(alive or asked))
    for worker in alive:
        worker.kill()
    return LearnerWorkerError(
        f"{names}: no answer within {seconds:g} s, so the workers were ended; {_KEPT}, {option} gives them more time"
    )


def lost_worker(asked: Sequence[BaseProcess], *, killed_only: bool = True) -> LearnerWorkerError | None:
    """The error to raise where a worker has died; None where none has.

    Args:
        asked: the workers.
        killed_only: True leaves out a worker that ended by itself, since it has raised its own error.
    """
    codes = {worker: _code(worker, _JOIN_S) for worker in asked}
    gone = [worker for worker, code in codes.items() if code is not None and (code < 0 or not killed_only)]
    # Libraries terminate the others when one dies, so look first for one that did not get SIGTERM.
    first = next((worker for worker in gone if codes[worker] != -signal.SIGTERM), gone[0] if gone else None)
    if first is None:
        return None
    code = codes[first] or 0
    how = f"killed by signal {-code}, as when memory runs out" if code < 0 else f"ended with code {code}"
    return LearnerWorkerError(f"{_names([first])[0]}: {how}; {_KEPT}")


def _code(worker: BaseProcess, wait_s: float = 0.0) -> int | None:
    """Exit code of a worker, waiting up to ``wait_s`` seconds for it; None while it runs."""
    try:
        if not worker.is_alive():
            worker.join(wait_s)
        return worker.exitcode
    except ValueError:  # the process object was closed
        return 0


def _names(workers: Sequence[BaseProcess]) -> list[str]:
    """Names of workers for a message; only the stopped ones, where the system tells which are."""
    stopped = [worker for worker in workers if _is_stopped(worker.pid)]
    return [f"worker {worker.name} (process {worker.pid})" for worker in stopped or workers]


def _is_stopped(pid: int | None) -> bool:
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8") as file:  # noqa: PTH123 (no path of ours)
            return file.read().rpartition(")")[2].split()[0] in ("T", "t")
    except (OSError, IndexError):
        return False
