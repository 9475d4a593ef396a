"""The pool of :mod:`ucon.core.pool`, whose processes are Ray actors."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Any, TypeVar

from ucon.cluster.crew import Crew
from ucon.cluster.luggage import Luggage
from ucon.cluster.roles import Calling

T = TypeVar("T")


class RayPool:
    """A pool on a cluster, used as a context manager; its actors end with the context.

    Args:
        ray: the module, connected.
        members: number of actors.
        begin: called first in each actor, with ``given``.
        given: sent to each actor once.
        patience_s: longest time for one result, seconds.
        luggage: what the actors need besides.
        cpus: CPUs of the cluster for each actor.
        gpus: GPUs of the cluster for each actor.
    """

    def __init__(
        self,
        ray: Any,
        members: int,
        begin: Callable[..., None] | None,
        given: tuple[Any, ...],
        patience_s: float,
        luggage: Luggage,
        *,
        cpus: float = 1.0,
        gpus: float = 0.0,
    ) -> None:
        role = Calling(begin, given)
        self._crew = Crew(ray, role, members, patience_s, luggage, cpus=cpus, gpus=gpus, option="the pool's patience")
        self._results: dict[int, Any] = {}
        self._asked = 0

    def submit(self, work: Callable[..., Any], *given: Any) -> int:
        """Start a piece of work; pieces begin in the order of submission.

        Args:
            work: a function that can be pickled.
            *given: its arguments.

        Returns:
            A number to give to :meth:`result`.
        """
        number, self._asked = self._asked, self._asked + 1
        self._crew.add([(number, (work, given))])
        return number

    def result(self, asked: int) -> Any:
        """Wait for the result of a piece of work.

        Args:
            asked: what :meth:`submit` returned.

        Raises:
            UconError: as :meth:`Crew.receive`.
        """
        while asked not in self._results:
            self._results.update(self._crew.receive())
        return self._results.pop(asked)

    def map(self, work: Callable[[T], Any], items: Iterable[T]) -> Iterator[Any]:
        """Results of ``work`` for all items, in order."""
        asked = deque([self.submit(work, item) for item in items])
        while asked:
            yield self.result(asked.popleft())

    def close(self) -> None:
        """End the actors at once."""
        self._crew.close()

    def __enter__(self) -> RayPool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
