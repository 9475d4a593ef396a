"""An agent that repeats recorded actions, to see an episode again without the original agent."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ucon.task.actions import Action


class RecordedAgent:
    """Plays one episode by its recorded actions."""

    name, uses_habits = "recorded", False

    def __init__(self, actions: str) -> None:
        """Set the actions.

        Args:
            actions: digits, as in :class:`ucon.evaluation.kept.record.EpisodeRecord`.
        """
        self._actions = actions
        self._left: Iterator[str] = iter(actions)

    def reset(self, infos: Sequence[Any], slots: Sequence[int] | None = None) -> None:
        """Begin again at the first action; there is one slot."""
        self._left = iter(self._actions)

    def act(self, observations: Sequence[Any], infos: Sequence[Any], slots: Sequence[int] | None = None) -> list[int]:
        """The next recorded action; Done where none is left, since the episode has then taken another course."""
        return [int(next(self._left, Action.DONE))]
