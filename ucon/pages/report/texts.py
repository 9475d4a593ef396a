"""The habits of a report: every sentence once, and by episode which were given, and which are about the target."""

from __future__ import annotations

from typing import Any

from ucon.envs.knowledge import HabitSource
from ucon.task.episode import Episode


class HabitTexts:
    """The table of sentences.

    Attributes:
        all: sentences, in the order in which they were first met.
    """

    def __init__(self) -> None:
        self.all: list[str] = []
        self._number: dict[str, int] = {}

    def of(self, source: HabitSource, episode: Episode, level: str) -> dict[str, list[int]]:
        """Sentences of an episode, as numbers in the table.

        Args:
            source: of the run.
            episode: the episode.
            level: habit level of the run.

        Returns:
            ``given`` in the order given to the agent, ``household`` (all), and ``about`` (those about the target).
        """
        given: Any = source.knowledge(episode, level)
        return {
            "given": [self._at(text) for text in given.texts],
            "household": [self._at(text) for text in source.knowledge(episode, "full").texts],
            "about": [self._at(text) for text in source.knowledge(episode, "gt").texts],
        }

    def _at(self, text: str) -> int:
        if text not in self._number:
            self._number[text] = len(self.all)
            self.all.append(text)
        return self._number[text]
