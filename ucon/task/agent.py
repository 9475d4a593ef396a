"""What an agent is: batches of observations in, one action for each environment out.

A slot is one environment of the batch. ``reset`` starts an episode in some slots, ``act`` answers for some slots; both
default to slots 0..n-1, so a single environment needs no slot numbers. Batches let language models and networks answer
for many environments in one call.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

Observation = Mapping[str, Any]
Info = Mapping[str, Any]


@runtime_checkable
class Agent(Protocol):
    """Chooses among the seven actions from observations and the non-privileged part of ``info``."""

    name: str
    """In tables. An agent whose ``uses_habits`` is False plays every habit level alike, and is evaluated once."""

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Start an episode in each of ``slots``; ``infos`` are the environments' infos at reset."""
        ...

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """One action (0..6) for each of ``slots``."""
        ...
