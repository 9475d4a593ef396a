"""Spreads episodes over worker processes. Which worker plays what is fixed beforehand, and changes no record.

Workers start from a fork server (or afresh where there is none), never by forking this process with its threads.
A worker that fails ends the run with its own traceback; a worker that dies says with which exit code.
"""

from __future__ import annotations

import multiprocessing
import os
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from typing import Any

from ucon.core.errors import ConfigError, UconError
from ucon.evaluation.play import Played, RunSpec, play
from ucon.task.episode import Episode

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")

OnPlayed = Callable[[Played], None]


class WorkerError(RuntimeError):
    """A worker failed; the message ends with its traceback."""


def resolve_workers(workers: int | str, n_episodes: int) -> int:
    """Number of worker processes: ``auto`` is one a usable core; 0 plays in this process; never more than episodes."""
    if workers == "auto":
        usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return max(1, min(usable, n_episodes))
    try:
        count = int(workers)
    except ValueError:
        count = -1
    if count < 0:
        raise ConfigError(f"workers={workers}: expected 'auto', or a number from 0 (in this process) up")
    return min(count, n_episodes)


def evaluate(
    spec: RunSpec,
    episodes: Sequence[Episode],
    *,
    workers: int | str = "auto",
    skip: Sequence[int] = (),
    on_played: OnPlayed | None = None,
) -> list[Played]:
    """Play all episodes but those at the indices ``skip``; sorted by index.

    Args:
        spec: agent, environment, habit level.
        episodes: what to play; their order gives the index of each.
        workers: see :func:`resolve_workers`.
        skip: indices that an earlier run has already played.
        on_played: called in this process with each episode as it ends, in no particular order.

    Raises:
        UconError: what a worker raised, unchanged.
        WorkerError: a worker failed in another way or died.
    """
    done = set(skip)
    jobs = [(i, episode) for i, episode in enumerate(episodes) if i not in done]
    count = resolve_workers(workers, len(jobs))
    source = play(spec, jobs) if count == 0 else _parallel(spec, jobs, count)
    found = []
    for played in source:
        found.append(played)
        if on_played is not None:
            on_played(played)
    return sorted(found, key=lambda p: p.index)


def _parallel(spec: RunSpec, jobs: Sequence[tuple[int, Episode]], count: int) -> Iterator[Played]:
    methods = multiprocessing.get_all_start_methods()
    context: Any = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
    if "forkserver" in methods:
        context.set_forkserver_preload(["ucon.evaluation.play", "ucon.envs"])
    processes: dict[Connection, Any] = {}
    try:
        with _one_thread_environment():
            for number in range(count):
                receiver, sender = context.Pipe(duplex=False)
                arguments = (sender, spec, jobs[number::count])
                process = context.Process(target=_work, args=arguments, name=f"ucon-eval-{number}", daemon=True)
                process.start()
                sender.close()
                processes[receiver] = process
        yield from _results(dict(processes))
    finally:
        for receiver, process in processes.items():
            if process.is_alive():
                process.terminate()
            process.join()
            receiver.close()


def _results(processes: dict[Connection, Any]) -> Iterator[Played]:
    while processes:
        for receiver in wait(list(processes)):
            assert isinstance(receiver, Connection)
            try:
                kind, content = receiver.recv()
            except EOFError:
                process = processes[receiver]
                process.join()
                raise WorkerError(
                    f"{process.name} died with exit code {process.exitcode} (negative: signal; -9: often out of "
                    "memory); try fewer workers, or workers=0 to run in this process"
                ) from None
            if kind == "played":
                yield content
            elif kind == "end":
                processes.pop(receiver).join()
            elif kind == "user":
                raise content
            else:
                raise WorkerError(f"{processes[receiver].name} failed:\n{content}")


def _work(sender: Connection, spec: RunSpec, jobs: Sequence[tuple[int, Episode]]) -> None:
    os.environ.update(_ONE_THREAD)
    try:
        for played in play(spec, jobs):
            sender.send(("played", played))
        sender.send(("end", None))
    except UconError as error:
        sender.send(("user", type(error)(str(error))))
    except KeyboardInterrupt:
        pass
    except BrokenPipeError:
        pass  # the parent has gone; nobody is left to tell
    except BaseException:
        sender.send(("crash", traceback.format_exc()))
    finally:
        sender.close()


@contextmanager
def _one_thread_environment() -> Iterator[None]:
    """Thread limits that children inherit before they import numpy or torch."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(_ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
