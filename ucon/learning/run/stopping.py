"""SIGINT and SIGTERM of a training run: it ends after the present step, or within it where that takes too long.

A step or validation that is still running some seconds after the signal is abandoned in the main thread: the state
before it is saved in the signal's handler, and then an exception is raised. Python runs the handler between two
instructions, so one long call into a library is waited for.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Final, NoReturn

#: Seconds after a signal in which the present step may end; the rest of five seconds is for saving.
GRACE_S: Final = 3.0
#: Seconds between two attempts to abandon a step: a finaliser or a callback of a library may swallow an exception.
_AGAIN_S: Final = 0.5


class AbandonedError(BaseException):
    """A step or validation was abandoned in the middle; what it left of the learner must not be used."""


class Stopping:
    """Signals that a run has received, and whether a step was abandoned for them.

    Args:
        on_abandoned: called with the signal's number when something is abandoned, before an exception leaves it.

    Attributes:
        caught: numbers of the received signals, in order.
        abandoned: whether a step or validation was abandoned. Libraries may then raise errors of their own.
    """

    def __init__(self, on_abandoned: Callable[[int], None]) -> None:
        self._on_abandoned = on_abandoned
        self.caught: list[int] = []
        self.abandoned = False
        self._inside = False
        self._deadline = float("inf")
        self._over = threading.Event()

    @contextmanager
    def abandonable(self) -> Iterator[None]:
        """Context manager: its body may be abandoned in the middle.

        Raises:
            AbandonedError: the body was still running, or began, more than :data:`GRACE_S` seconds after a signal.
        """
        if self._late():
            self._abandon()
        self._inside = True
        try:
            yield
        finally:
            self._inside = False

    def settle(self) -> None:
        """From now on, nothing is abandoned."""
        self._inside = False
        self._over.set()

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Handler of both signals; a second SIGINT raises at once."""
        if self._inside and self._late():
            self._abandon()
        if self.caught and number == signal.SIGINT:
            raise KeyboardInterrupt
        if not self.caught:
            told = f"stopping after this step, within {GRACE_S:g} s; Ctrl-C again aborts it at once\n"
            sys.stderr.write(told)
            sys.stderr.flush()
            self._deadline = time.monotonic() + GRACE_S
            threading.Thread(target=self._remind, args=(threading.get_ident(),), daemon=True).start()
        self.caught.append(number)

    def _abandon(self) -> NoReturn:
        if not self.abandoned:
            self.abandoned, self._inside = True, False  # no signal disturbs the saving
            self._on_abandoned(self.caught[0])
            self._inside = True
        raise AbandonedError

    def _late(self) -> bool:
        return time.monotonic() >= self._deadline

    def _remind(self, main: int) -> None:
        """When the time is up, signal the main thread repeatedly until it has left what it was doing."""
        wait_s = self._deadline - time.monotonic() + 0.01
        while not self._over.wait(max(0.0, wait_s)):
            if self._inside:
                signal.pthread_kill(main, signal.SIGTERM)
            wait_s = _AGAIN_S


@contextmanager
def stopping(on_abandoned: Callable[[int], None]) -> Iterator[Stopping]:
    """Context manager: SIGINT and SIGTERM are recorded inside it, where this is the main thread.

    In another thread no handlers can be set; the caller deals with signals.

    Args:
        on_abandoned: see :class:`Stopping`.
    """
    stop = Stopping(on_abandoned)
    try:
        before = {number: signal.signal(number, stop.handle) for number in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:
        yield stop
        return
    try:
        yield stop
    finally:
        stop.settle()
        for number, handler in before.items():
            signal.signal(number, handler)


def end_at_once(message: str, code: int) -> NoReturn:
    """End this process and its children without closing or finalising anything; may be called in a signal's handler.

    Libraries that were interrupted, such as a collector that is starting its workers, wait long or forever to close.

    Args:
        message: a line for standard error.
        code: exit code.
    """
    for child in multiprocessing.active_children():
        child.kill()
    for pid in _half_started():
        with contextlib.suppress(OSError):
            os.kill(pid, signal.SIGKILL)
    shown = "\x1b[?25h" if sys.stderr.isatty() else ""  # the cursor, which a progress line may have hidden
    with contextlib.suppress(RuntimeError):  # they were being written to
        sys.stdout.flush()
        sys.stderr.flush()
    os.write(2, f"{shown}{message}\n".encode())
    os._exit(code)


def _half_started() -> Iterator[int]:
    """Process ids, from Linux, of workers that multiprocessing does not know yet; left alone, they print errors."""
    for path in Path("/proc/self/task").glob("*/children"):
        for pid in path.read_text().split():
            with contextlib.suppress(OSError):
                if b"multiprocessing.spawn" in Path(f"/proc/{pid}/cmdline").read_bytes():
                    yield int(pid)
