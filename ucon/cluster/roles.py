"""The two kinds of work of a crew: playing episodes or lives, and calling functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile
from typing import Any, Final, Protocol

from ucon.evaluation.playing.jobs import Job, play_on
from ucon.evaluation.playing.play import RunSpec
from ucon.evaluation.playing.stage import Stage
from ucon.lives.asked import Asked

#: Most episodes of a piece: if a worker dies, all of them may have to be played again.
_MOST: Final = 32
#: Pieces per worker into which the waiting jobs are cut, so that all workers end at nearly the same time.
_PIECES: Final = 4


def piece_size(count: int, at_once: int, members: int) -> int:
    """How many of ``count`` waiting episodes a member is given; pieces shrink, since the last ones decide the end.

    Args:
        count: number of waiting episodes.
        at_once: episodes that a member plays at once.
        members: number of members of the crew.
    """
    return min(count, max(at_once, min(_MOST, count // (_PIECES * members))))


class Role(Protocol):
    """The work of a crew's members; pickled and sent to them."""

    @property
    def at_once(self) -> int:
        """Jobs of a piece that a member works on at the same time."""
        ...

    def begin(self) -> Any:
        """State of a member, made once."""
        ...

    def work(self, state: Any, jobs: Sequence[tuple[int, Any]]) -> Iterator[tuple[int, Any]]:
        """Do jobs, and yield the number and the result of each as it ends."""
        ...

    def piece(self, waiting: Iterable[tuple[int, Any]], count: int, members: int) -> int:
        """How many of the ``count`` waiting jobs a member is given next."""
        ...

    def name(self, job: tuple[int, Any]) -> str:
        """Name of a job in messages."""
        ...


@dataclass(frozen=True)
class Playing:
    """Plays episodes or lives."""

    spec: RunSpec

    @property
    def at_once(self) -> int:
        """Number of environments whose observations the agent is given together."""
        return self.spec.batch

    def begin(self) -> Stage:
        """The agent and its environments."""
        return Stage(self.spec.agent, self.spec.env)

    def work(self, state: Stage, jobs: Sequence[Job]) -> Iterator[tuple[int, Any]]:
        """Play jobs; yields their indices with their :class:`PlayedEpisode`."""
        for played in play_on(state, self.spec, jobs):
            yield played.index, played

    def piece(self, waiting: Iterable[Job], count: int, members: int) -> int:
        """The requests of as many whole lives as are played at once; for episodes see :func:`piece_size`."""
        first = next(iter(waiting))[1]
        if not isinstance(first, Asked):
            return piece_size(count, self.at_once, members)
        lives: dict[str, int] = {}
        for _ in takewhile(lambda job: _counted(job, lives) <= self.at_once, waiting):
            pass
        return sum(list(lives.values())[: self.at_once])

    def name(self, job: Job) -> str:
        """Identifier of the episode, or of the request."""
        return job[1].id


def _counted(job: Job, lives: dict[str, int]) -> int:
    """Count a request for its life; returns the number of lives so far."""
    asked = job[1]
    assert isinstance(asked, Asked)
    lives[asked.life.id] = lives.get(asked.life.id, 0) + 1
    return len(lives)


@dataclass(frozen=True)
class Calling:
    """Calls functions, one after the other; a job is a function with its arguments."""

    start: Callable[..., None] | None = None
    given: tuple[Any, ...] = ()
    at_once = 1

    def begin(self) -> None:
        """Call ``start``, which comes first in each process."""
        if self.start is not None:
            self.start(*self.given)

    def work(self, state: None, jobs: Sequence[tuple[int, Any]]) -> Iterator[tuple[int, Any]]:
        """Call the functions; yields what they return."""
        for number, (function, given) in jobs:
            yield number, function(*given)

    def piece(self, waiting: Iterable[tuple[int, Any]], count: int, members: int) -> int:
        """One job at a time."""
        return 1

    def name(self, job: tuple[int, Any]) -> str:
        """Number of the job."""
        return f"piece {job[0]}"
