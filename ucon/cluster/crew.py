"""A crew of Ray actors that work through jobs, and are replaced if they die or stop answering.

A member is given a piece, which is some of the waiting jobs, and returns the result of each job as it ends. Jobs that
a lost member had not returned go back into the queue, so no job is lost, and none is counted twice.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
import traceback
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from ucon.cluster.luggage import Luggage
from ucon.cluster.roles import Role
from ucon.core.errors import ConfigError, EpisodeError, UconError
from ucon.evaluation.playing.crew import TRIES, WorkerError

#: Most seconds between two checks for silent members.
_TICK_S: Final = 1.0
#: Seconds within which the first member has to be given a place in the cluster.
PLACE_S: Final = 300.0


class _Actor:
    """The process of a member, somewhere in the cluster."""

    def place(self) -> tuple[str, int]:
        """Address of the machine, and number of the process."""
        import ray

        return ray.util.get_node_ip_address(), os.getpid()

    def begin(self, luggage: Luggage, kept: Sequence[Any]) -> tuple[str, Any]:
        """Get ready to work. The role is read from Ray's store only after the luggage, with its homes, is unpacked."""
        import ray

        try:
            luggage.unpack()
            self._role: Role = ray.get(kept[0])
            self._state = self._role.begin()
        except UconError as error:
            return "user", type(error)(str(error))
        except BaseException:
            return "crash", traceback.format_exc()
        return "ready", None

    def work(self, jobs: Sequence[tuple[int, Any]]) -> Iterator[tuple[str, Any]]:
        """Do jobs; yields messages."""
        try:
            for number, result in self._role.work(self._state, jobs):
                yield "done", (number, result)
        except UconError as error:
            yield "user", type(error)(str(error))
        except GeneratorExit:
            raise
        except BaseException:
            yield "crash", traceback.format_exc()


@dataclass(eq=False)
class _Member:
    """An actor, what is awaited from it, and the jobs that it has yet to do, in order."""

    name: str
    actor: Any
    awaited: Any
    phase: Literal["placed", "begins", "idle", "works"] = "placed"
    where: str = ""
    left: list[tuple[int, Any]] = field(default_factory=list)
    silent_s: float = 0.0

    def __str__(self) -> str:
        return f"{self.name}{self.where}"


class Crew:
    """Members that work through jobs; :meth:`close` ends them.

    Args:
        ray: the module, connected.
        role: what they do.
        members: how many.
        patience_s: most seconds for a job, and for getting ready.
        luggage: what they need besides the role.
        cpus: CPUs of the cluster for each member.
        gpus: GPUs of the cluster for each member.
        option: name of the option that raises ``patience_s``, for messages.
    """

    def __init__(
        self,
        ray: Any,
        role: Role,
        members: int,
        patience_s: float,
        luggage: Luggage,
        *,
        cpus: float = 1.0,
        gpus: float = 0.0,
        option: str = "worker_timeout_s",
    ) -> None:
        self._ray, self._role, self._patience_s, self._option = ray, role, patience_s, option
        self._actor = ray.remote(num_cpus=cpus, num_gpus=gpus, max_restarts=0, max_task_retries=0)(_Actor)
        self._given = ray.put(luggage), [ray.put(role)]
        self._size, self._tick_s = members, min(_TICK_S, patience_s / 4)
        self._waiting: deque[tuple[int, Any]] = deque()
        self._members: list[_Member] = []
        self._failed: Counter[int] = Counter()
        self._started = self._lost_in_a_row = 0
        self._nowhere_s = 0.0

    def add(self, jobs: Iterable[tuple[int, Any]]) -> None:
        """Add jobs to the queue; they are begun in this order."""
        self._waiting.extend(jobs)

    @property
    def busy(self) -> bool:
        """Whether any job is not done yet."""
        return bool(self._waiting) or any(member.left for member in self._members)

    def receive(self) -> list[tuple[int, Any]]:
        """Wait up to a second for jobs to end; returns the numbers and results of those that did.

        Raises:
            UconError: raised by a member, unchanged.
            EpisodeError: a job that no member did in time.
            ConfigError: the cluster gave no member a place.
            WorkerError: a member failed in another way, or member after member dies.
        """
        self._assign()
        begun = time.monotonic()
        awaited = {m.awaited: m for m in self._members if m.awaited is not None}
        ready, _ = self._ray.wait(list(awaited), num_returns=1, timeout=self._tick_s) if awaited else ([], [])
        found: list[tuple[int, Any]] = []
        while ready:
            found += self._handle(awaited[ready[0]])
            awaited = {m.awaited: m for m in self._members if m.awaited is not None}
            ready, _ = self._ray.wait(list(awaited), num_returns=1, timeout=0) if awaited else ([], [])
        # Time in which this process itself was suspended does not count as silence.
        self._wait_for_silent(min(time.monotonic() - begun, 2 * self._tick_s))
        return found

    def close(self) -> None:
        """End all members."""
        while self._members:
            self._kill(self._members.pop())

    def _assign(self) -> None:
        """Start members as long as there are jobs for more of them, and give pieces to idle ones."""
        working = sum(bool(member.left) for member in self._members)
        wanted = min(self._size, working + len(self._waiting))
        while len(self._members) < wanted:
            self._start()
        for member in self._members:
            if member.phase == "idle" and self._waiting:
                count = self._role.piece(self._waiting, len(self._waiting), self._size)
                member.left = [self._waiting.popleft() for _ in range(count)]
                member.awaited = member.actor.work.options(num_returns="streaming").remote(member.left)
                member.phase, member.silent_s = "works", 0.0

    def _start(self) -> None:
        actor = self._actor.remote()
        self._members.append(_Member(f"worker {self._started}", actor, actor.place.remote()))
        self._started += 1

    def _handle(self, member: _Member) -> list[tuple[int, Any]]:
        """Take what a member returned; the list is empty if that was no result."""
        errors = self._ray.exceptions
        try:
            content = self._taken(member)
        except errors.RayTaskError as error:  # what it returned cannot be pickled, or it ended itself
            raise WorkerError(f"{member} failed:\n{error}") from None
        except errors.RayError as error:
            self._replace(member, f"died ({_first_line(error)})")
            return []
        member.silent_s = 0.0
        if member.phase == "placed":
            member.where = " (process {1} on {0})".format(*content)
            member.awaited, member.phase = member.actor.begin.remote(*self._given), "begins"
            return []
        if content is None:  # the end of a piece
            member.awaited, member.phase = None, "idle"
            return []
        kind, result = content
        if kind == "user":
            raise result
        if kind == "crash":
            raise WorkerError(f"{member} failed:\n{result}")
        self._lost_in_a_row = 0
        if kind == "ready":
            member.awaited, member.phase = None, "idle"
            return []
        member.left = [job for job in member.left if job[0] != result[0]]
        return [result]

    def _taken(self, member: _Member) -> Any:
        """The next thing that a member returned; None at the end of a piece."""
        if member.phase != "works":
            return self._ray.get(member.awaited)
        try:
            return self._ray.get(next(member.awaited))
        except StopIteration:
            return None

    def _wait_for_silent(self, passed_s: float) -> None:
        """Replace members that have been silent for too long."""
        placed = [member for member in self._members if member.phase != "placed"]
        self._nowhere_s = 0.0 if placed or not self._members else self._nowhere_s + passed_s
        if self._nowhere_s > PLACE_S:
            raise ConfigError(
                f"the cluster had no room for a worker within {PLACE_S:g} s; it has "
                f"{self._ray.cluster_resources().get('CPU', 0):g} CPUs: see `ray status`"
            )
        for member in placed:
            if member.phase == "idle":
                continue
            member.silent_s += passed_s
            running = member.left[: self._role.at_once]
            if member.silent_s > (limit := self._patience_s * max(1, len(running))):
                what = ", ".join(map(self._role.name, running)) or "its start"
                self._replace(member, f"did not finish {what} within {limit:g} s ({self._option})", hangs=True)

    def _replace(self, member: _Member, why: str, *, hangs: bool = False) -> None:
        """End a member and put its jobs back into the queue, unless one of them was tried too often."""
        self._members.remove(member)
        self._kill(member)
        running = member.left[: self._role.at_once]
        self._failed.update(number for number, _ in running)
        self._lost_in_a_row += 1
        if worst := [self._role.name(job) for job in running if self._failed[job[0]] >= TRIES]:
            text = (
                f"{', '.join(worst)}: not finished by any of {TRIES} workers; the last one, {member}, {why}; finished "
                f"work is kept and the same command continues; run it without Ray to see why, or raise {self._option}"
            )
            raise EpisodeError(text) if hangs else WorkerError(text)
        if self._lost_in_a_row > TRIES * self._size:
            raise WorkerError(f"{self._lost_in_a_row} workers in a row were lost; the last one, {member}, {why}")
        sys.stderr.write(f"warning: {member} {why}; it is stopped, and its remaining episodes go to other workers\n")
        self._waiting.extendleft(reversed(member.left))

    def _kill(self, member: _Member) -> None:
        """End a member in any state; Ray sends SIGKILL to a process that does not end by itself."""
        with contextlib.suppress(self._ray.exceptions.RayError):  # its machine may be gone
            self._ray.kill(member.actor, no_restart=True)


def _first_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    reasons = [line for line in lines if line.startswith(("The actor is dead because", "Worker exit"))]
    return (reasons or lines or [type(error).__name__])[0].rstrip(".")[:200]
