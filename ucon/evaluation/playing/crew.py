"""Worker processes that play shares of the episodes, and are replaced when they stop answering or die.

A stopped process does not end when asked to, and may leave half a message in its pipe. So a thread for each worker
reads its pipe, and a worker that is silent for too long is killed; a new one plays the rest of its share.
"""

from __future__ import annotations

import multiprocessing
import os
import queue
import sys
import threading
import time
import traceback
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from typing import Any, Final

from ucon.core.errors import EpisodeError, UconError
from ucon.core.pool import ONE_THREAD
from ucon.evaluation.playing.jobs import Job, play
from ucon.evaluation.playing.play import PlayedEpisode, RunSpec

#: How often an episode is tried before it counts as never ending.
TRIES: Final = 3
#: Longest time in seconds between two checks of silent workers.
_TICK_S: Final = 1.0
#: Seconds to wait for a process to end; within a system call it may survive even SIGKILL.
_END_S: Final = 10.0


class WorkerError(RuntimeError):
    """A worker failed; the message ends with its traceback."""


@dataclass(eq=False)
class _Worker:
    """A process, its pipe, and the jobs that it has yet to play, in order."""

    process: Any
    receiver: Connection
    left: list[Job]
    silent_s: float = 0.0
    reader: threading.Thread = field(init=False)


class WorkerPool:
    """Pool of worker processes; :meth:`close` ends them.

    Args:
        spec: agent, environment, habit level.
        timeout_s: time limit per episode; a worker with several environments is allowed this time for each of them,
            since they take turns.
    """

    def __init__(self, spec: RunSpec, timeout_s: float) -> None:
        methods = multiprocessing.get_all_start_methods()
        self._context: Any = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
        if "forkserver" in methods:
            self._context.set_forkserver_preload(["ucon.evaluation.playing.play", "ucon.envs"])
        self._spec, self._timeout_s = spec, timeout_s
        self._tick_s = min(_TICK_S, timeout_s / 4)
        self._news: queue.SimpleQueue[tuple[_Worker, str, Any]] = queue.SimpleQueue()
        self._working: list[_Worker] = []
        self._ended: list[_Worker] = []
        self._failed: Counter[int] = Counter()

    def play(self, shares: Sequence[Sequence[Job]]) -> Iterator[PlayedEpisode]:
        """Play each share in a process of its own; yields episodes as they end.

        Args:
            shares: lists of (index, episode).

        Raises:
            UconError: raised by a worker, unchanged.
            EpisodeError: an episode that no worker finished in time.
            WorkerError: a worker failed in another way, or every worker that tried an episode died.
        """
        for number, share in enumerate(shares):
            self._start(f"ucon-eval-{number}", share)
        while self._working:
            for worker, kind, content in self._receive():
                if worker in self._working:  # messages of a replaced worker are dropped
                    yield from self._handle(worker, kind, content)
            for worker in list(self._working):
                if worker.silent_s > self._limit_s(worker):
                    self._replace_silent(worker)

    def close(self) -> None:
        """End all processes: idle ones by themselves, the others are killed."""
        for worker in self._ended:
            worker.process.join(_END_S)
        while workers := self._working or self._ended:
            _kill(workers.pop())

    def _start(self, name: str, jobs: Sequence[Job]) -> None:
        with _one_thread_environment():
            receiver, sender = self._context.Pipe(duplex=False)
            process = self._context.Process(target=_work, args=(sender, self._spec, jobs), name=name, daemon=True)
            process.start()
            sender.close()
        worker = _Worker(process, receiver, list(jobs))
        worker.reader = threading.Thread(target=_read, args=(worker, self._news), name=f"{name}-reader", daemon=True)
        self._working.append(worker)
        worker.reader.start()

    def _receive(self) -> list[tuple[_Worker, str, Any]]:
        """Messages that arrived within a tick.

        Time in which this process itself was suspended does not count as silence.
        """
        news, begun = [], time.monotonic()
        try:
            news.append(self._news.get(timeout=self._tick_s))
            while True:
                news.append(self._news.get_nowait())
        except queue.Empty:
            pass
        passed = min(time.monotonic() - begun, 2 * self._tick_s)
        for worker in self._working:
            worker.silent_s += passed
        return news

    def _handle(self, worker: _Worker, kind: str, content: Any) -> Iterator[PlayedEpisode]:
        if kind == "played":
            worker.silent_s = 0.0
            worker.left = [job for job in worker.left if job[0] != content.index]
            yield content
        elif kind == "end":
            self._working.remove(worker)
            self._ended.append(worker)
        elif kind == "user":
            raise content
        elif kind == "gone":
            self._replace_dead(worker)
        else:
            raise WorkerError(f"{worker.process.name} failed:\n{content}")

    def _limit_s(self, worker: _Worker) -> float:
        return self._timeout_s * max(1, len(worker.left[: self._spec.batch]))

    def _replace_silent(self, worker: _Worker) -> None:
        """Replace a worker that did not answer in time.

        Raises:
            EpisodeError: an episode was tried too often.
        """
        limit = self._limit_s(worker)
        running, worst = self._ended_in(worker)
        if worst:
            raise EpisodeError(
                f"{worst}: not finished within {limit:g} s by any of {TRIES} workers; finished episodes are kept "
                "and the same command continues; play with workers=0 to see where it hangs, or raise worker_timeout_s"
            )
        self._go_on(worker, f"did not finish {running} within {limit:g} s (worker_timeout_s) and was stopped")

    def _replace_dead(self, worker: _Worker) -> None:
        """Replace a worker that died.

        Raises:
            WorkerError: an episode was tried too often.
        """
        worker.process.join(_END_S)
        how = f"died with exit code {worker.process.exitcode} (negative: signal; -9: often out of memory)"
        running, worst = self._ended_in(worker)
        if worst:
            raise WorkerError(
                f"{worker.process.name} {how}, as did others: {TRIES} workers began {worst}; finished episodes are "
                "kept and the same command continues; try fewer workers, or workers=0 to run in this process"
            )
        self._go_on(worker, f"{how} in {running}")

    def _ended_in(self, worker: _Worker) -> tuple[str, str]:
        """End a worker; returns the names of the episodes that it was playing, and of those tried too often."""
        running = worker.left[: self._spec.batch]
        self._working.remove(worker)
        _kill(worker)
        self._failed.update(index for index, _ in running)
        worst = [episode.id for index, episode in running if self._failed[index] >= TRIES]
        return ", ".join(episode.id for _, episode in running), ", ".join(worst)

    def _go_on(self, worker: _Worker, how: str) -> None:
        """Start a new process for the rest of a worker's share, unless only its last message was missing."""
        name = worker.process.name
        if worker.left:
            sys.stderr.write(f"warning: {name} {how}, so another worker plays that episode again\n")
            self._start(name, worker.left)


def _kill(worker: _Worker) -> None:
    """Kill a process in any state; a stopped one reacts to nothing else."""
    worker.process.kill()
    worker.process.join(_END_S)
    worker.reader.join(_END_S)
    if not worker.reader.is_alive():
        worker.receiver.close()


def _read(worker: _Worker, news: queue.SimpleQueue[tuple[_Worker, str, Any]]) -> None:
    """Pass on a worker's messages until its pipe ends; half a message blocks only this thread."""
    try:
        while True:
            news.put((worker, *worker.receiver.recv()))
    except Exception:  # the pipe has ended, or the message cannot be read
        news.put((worker, "gone", None))


def _work(sender: Connection, spec: RunSpec, jobs: Sequence[Job]) -> None:
    os.environ.update(ONE_THREAD)
    try:
        for played in play(spec, jobs):
            sender.send(("played", played))
        sender.send(("end", None))
    except UconError as error:
        sender.send(("user", type(error)(str(error))))
    except KeyboardInterrupt:
        pass
    except BrokenPipeError:
        pass  # the parent process has ended
    except BaseException:
        sender.send(("crash", traceback.format_exc()))
    finally:
        sender.close()


@contextmanager
def _one_thread_environment() -> Iterator[None]:
    """Context manager: limits threads in processes started inside it, before they import numpy or torch."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
