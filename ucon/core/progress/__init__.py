"""Progress on standard error: a bar in a terminal, otherwise a plain line from time to time."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar, Token
from types import TracebackType
from typing import Any, Final, TypeVar

#: Least and greatest time between two plain lines, seconds.
LEAST_S: Final = 5.0
MOST_S: Final = 30.0
#: A plain line is due after this share of the work, within the times above.
SHARE: Final = 0.1

Tick = Callable[[int], None]
T = TypeVar("T")


class Progress:
    """Progress of one task, used as a context."""

    def __init__(
        self, label: str, total: int, *, unit: str = "", done: int = 0, note: str = "", visible: bool = True
    ) -> None:
        """Describe the task.

        Args:
            label: what is being done.
            total: amount of work.
            unit: of the work, in the plural.
            done: amount done before; it does not count for the rate.
            note: further text at the end of the line.
            visible: False shows nothing.
        """
        shown = _Nothing if not visible else _Bar if _at_a_terminal() else _Lines
        self._shown: _Nothing | _Bar | _Lines = shown(label, total, unit, done, note)
        self._token: Token[Progress | None] | None = None

    def update(self, done: int, note: str | None = None) -> None:
        """Report the amount of work done so far.

        Args:
            done: amount.
            note: replaces the note, unless None.
        """
        self._shown.update(done, note)

    def start_part(self, label: str, total: int | None) -> None:
        """Begin a long part of a step.

        Args:
            label: what is being done.
            total: amount of work; None where it is not counted.
        """
        self._shown.start_part(label, total)

    def update_part(self, done: int) -> None:
        """Report the amount done of the current part."""
        self._shown.update_part(done)

    def end_part(self) -> None:
        """End the current part."""
        self._shown.end_part()

    def __enter__(self) -> Progress:
        self._token = _CURRENT.set(self)
        self._shown.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._token is not None:
            _CURRENT.reset(self._token)
        self._shown.stop()


_CURRENT: ContextVar[Progress | None] = ContextVar("progress", default=None)


@contextmanager
def part(label: str, total: int | None = None) -> Iterator[Tick]:
    """Context for a long part of a step, shown below the current progress; without one nothing is shown.

    Args:
        label: what is being done.
        total: amount of work; None: not counted, and a bar estimates the time left from how long it took last time.

    Yields:
        A function to call with the amount done.
    """
    shown = _CURRENT.get()
    if shown is None:
        yield lambda done: None
        return
    shown.start_part(label, total)
    try:
        yield shown.update_part
    finally:
        shown.end_part()


def ticked(label: str, items: Sequence[T]) -> Iterator[T]:
    """The items one by one, with progress shown as a :func:`part`."""
    with part(label, len(items)) as tick:
        for number, item in enumerate(items, 1):
            yield item
            tick(number)


def duration(seconds: float) -> str:
    """Seconds as text: ``42 s``, ``3 min``, ``1 h 05 min``."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def _at_a_terminal() -> bool:
    return sys.stderr.isatty() and os.environ.get("TERM") != "dumb"


class _Nothing:
    """Shows nothing."""

    def __init__(self, *told: Any) -> None:
        pass

    def start(self) -> None:
        pass

    def update(self, done: int, note: str | None) -> None:
        pass

    def start_part(self, label: str, total: int | None) -> None:
        pass

    def update_part(self, done: int) -> None:
        pass

    def end_part(self) -> None:
        pass

    def stop(self) -> None:
        pass


class _Bar:
    """A live bar, and a second one for a part."""

    def __init__(self, label: str, total: int, unit: str, done: int, note: str) -> None:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Task,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )
        from rich.progress import Progress as Bars
        from rich.text import Text

        class Left(TimeRemainingColumn):
            """The time left; for a part without a total, estimated from how long it took last time."""

            def render(self, task: Task) -> Text:
                usual = task.fields["usual_s"]
                if usual is None or task.total is not None:
                    return super().render(task)
                return Text(duration(max(0.0, usual - (task.elapsed or 0.0))), style="progress.remaining")

        columns = (
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[note]}"),
            TimeElapsedColumn(), Left(),
        )  # fmt: skip
        self._bars = Bars(*columns, console=Console(stderr=True))
        self._task = self._bars.add_task(label, total=total, completed=done, note=note, usual_s=None)
        self._parts: list[tuple[Any, str, float]] = []
        self._took: dict[str, float] = {}

    def start(self) -> None:
        self._bars.start()

    def update(self, done: int, note: str | None) -> None:
        self._bars.update(self._task, completed=done)
        if note is not None:
            self._bars.update(self._task, note=note)

    def start_part(self, label: str, total: int | None) -> None:
        task = self._bars.add_task(f"  {label}", total=total, note="", usual_s=self._took.get(label))
        self._parts.append((task, label, time.monotonic()))

    def update_part(self, done: int) -> None:
        self._bars.update(self._parts[-1][0], completed=done)

    def end_part(self) -> None:
        task, label, began = self._parts.pop()
        self._took[label] = time.monotonic() - began
        self._bars.remove_task(task)

    def stop(self) -> None:
        self._bars.stop()


class _Lines:
    """A line at the beginning, at the end, and from time to time in between."""

    def __init__(
        self, label: str, total: int, unit: str, done: int, note: str, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._label, self._total, self._unit, self._note = label, total, unit, note
        self._first = self._done = self._told = done
        self._clock = clock
        self._began = self._last = clock()
        self._part, self._part_total, self._part_began = "", 0, 0.0

    def start(self) -> None:
        self._began = self._clock()
        self._say()

    def update(self, done: int, note: str | None) -> None:
        self._done, self._note = done, self._note if note is None else note
        waited = self._clock() - self._last
        more = self._total > 0 and (done - self._told) / self._total >= SHARE
        if waited >= MOST_S or (more and waited >= LEAST_S):
            self._say()

    def start_part(self, label: str, total: int | None) -> None:
        self._part, self._part_total, self._part_began = label, total or 0, self._clock()
        self.update_part(0)

    def update_part(self, done: int) -> None:
        if self._clock() - self._last >= MOST_S:
            much = f" {done} of {self._part_total}" if self._part_total else ""
            spent = self._clock() - self._part_began
            left = f" ({duration(spent / done * (self._part_total - done))} left)" if much and done else ""
            self._say(f"{self._part}{much}{left}")

    def end_part(self) -> None:
        self._part = ""

    def stop(self) -> None:
        if self._done != self._told:
            self._say()

    def _say(self, also: str = "") -> None:
        self._told, self._last = self._done, self._clock()
        parts = [f"{self._done} of {self._total} {self._unit}".rstrip(), *self._speed(), also, self._note]
        sys.stderr.write(f"{self._label}: {', '.join(one for one in parts if one)}\n")
        sys.stderr.flush()

    def _speed(self) -> list[str]:
        """Rate and remaining time as text; for finished work, the time it took."""
        new, seconds = self._done - self._first, self._clock() - self._began
        if new <= 0 or seconds <= 0.0:
            return []
        rate = new / seconds
        speed = f"{rate:.1f} a second" if rate >= 1 else f"{60 * rate:.1f} a minute"
        left = self._total - self._done
        return [speed, f"{duration(left / rate)} left" if left > 0 else f"in {duration(seconds)}"]
