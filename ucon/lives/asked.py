"""A request of a life in the form in which runs play it, besides episodes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ucon.core.errors import EpisodeError
from ucon.core.sharing import Shared
from ucon.habits.book import contexts_book
from ucon.habits.types import HabitDataset
from ucon.lives.asking import Asking
from ucon.lives.life import Life
from ucon.task.episode import Episode


@dataclass(frozen=True)
class Asked(Shared):
    """One request of a life. The requests of a life are played in order, by one worker.

    Attributes:
        life: the life.
        number: number of the request, from 0.
    """

    life: Life
    number: int

    @property
    def id(self) -> str:
        """The id of its episode."""
        return f"{self.life.id}/{self.number:03d}"

    @property
    def hash(self) -> str:
        """Hash of its life, since what comes before a request affects its outcome."""
        return self.life.hash

    @property
    def habits_hash(self) -> str:
        """SHA-256 of the habit dataset."""
        return self.life.habits_hash

    @property
    def task(self) -> str:
        """Rule set."""
        return self.life.task


def asked_of(lives: Iterable[Life]) -> tuple[Asked, ...]:
    """All requests of some lives, in order."""
    return tuple(Asked(life, number) for life in lives for number in range(len(life.requests)))


def example(asked: Asked, dataset: HabitDataset | None = None) -> Episode:
    """A request as an episode that begins at the dock.

    Args:
        asked: the request.
        dataset: the habits with which its life was made; by default the habit book with its second part.
    """
    asking = Asking(asked.life, dataset or contexts_book())
    return asking.episode(asked.number, asking.standing(asked.number, asked.life.dock))


def by_life(jobs: Sequence[tuple[int, Asked]]) -> list[list[tuple[int, Asked]]]:
    """Group jobs by life, in order.

    Args:
        jobs: (index, request) pairs; those of a life in the order of their requests.

    Raises:
        EpisodeError: the requests of a life are not in order.
    """
    groups: dict[str, list[tuple[int, Asked]]] = {}
    for job in jobs:
        groups.setdefault(job[1].life.id, []).append(job)
    for group in groups.values():
        numbers = [asked.number for _, asked in group]
        if numbers != sorted(numbers):
            raise EpisodeError(f"life {group[0][1].life.id}: requests {numbers}, expected them in order")
    return list(groups.values())
