"""The interface of what a robot remembers from one request to the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from ucon.lives.request_record import BelievedPlace

Info = Mapping[str, Any]
Observation = Mapping[str, Any]


class Memory(Protocol):
    """One robot's memory in one home. Around each request of a life :meth:`begin` and :meth:`end` are called."""

    name: str
    """Name in tables."""
    uses_habits: bool
    """Whether what it says of places depends on the habits that are told, such as on the days of news."""
    believed: tuple[BelievedPlace, ...] | None
    """Where it held the target of the running request to be as that began, the likeliest first; None if it remembers no
    places."""

    def patrol(self, observation: Observation, info: Info) -> int:
        """The next action of a patrol, after its frame was taken in; the first frame of the day begins it.

        Args:
            observation: of the frame.
            info: of the frame, with ``patrol``.
        """
        ...

    def begin(self, info: Info) -> dict[str, Any]:
        """Begin a request.

        Args:
            info: of its first frame.

        Returns:
            The info for the agent's reset, with what the agent may use of the memory.
        """
        ...

    def look(self, observation: Observation, info: Info) -> None:
        """Take in a frame, after the agent has.

        Args:
            observation: of the frame.
            info: of the frame.
        """
        ...

    def act(self, action: int, observation: Observation) -> int:
        """The action that is carried out on a frame.

        Args:
            action: the agent's.
            observation: of the frame.
        """
        ...

    def end(self) -> None:
        """End a request."""
        ...
