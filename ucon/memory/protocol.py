"""The interface of a robot's memory from one request to the next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from ucon.lives.request_record import BelievedPlace

Info = Mapping[str, Any]
Observation = Mapping[str, Any]


class Memory(Protocol):
    """One robot's memory in one home. :meth:`begin` and :meth:`end` are called around each request of a life."""

    name: str
    """Name in tables."""
    uses_habits: bool
    """Whether its beliefs about places depend on the habits given, for example on the days on which they were new."""
    believed: tuple[BelievedPlace, ...] | None
    """Places where it believed the target to be when the current request began, the likeliest first; None if it
    remembers no places."""

    def patrol(self, observation: Observation, info: Info) -> int:
        """Take in a frame of a patrol, and return the next action; the first frame of the day begins the patrol.

        Args:
            observation: observation of the frame.
            info: info of the frame, with ``patrol``.
        """
        ...

    def begin(self, info: Info) -> dict[str, Any]:
        """Begin a request.

        Args:
            info: info of its first frame.

        Returns:
            The info for the agent's reset, with the parts of the memory that the agent may use.
        """
        ...

    def look(self, observation: Observation, info: Info) -> None:
        """Take in a frame, after the agent has done so.

        Args:
            observation: observation of the frame.
            info: info of the frame.
        """
        ...

    def act(self, action: int, observation: Observation) -> int:
        """The action to carry out after a frame.

        Args:
            action: the agent's action.
            observation: observation of the frame.
        """
        ...

    def end(self) -> None:
        """End a request."""
        ...
