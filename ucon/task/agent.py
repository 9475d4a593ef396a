"""The agent interface: a batch of observations in, one action for each environment out.

A slot is one environment of the batch. ``reset`` starts an episode in the given slots, ``act`` chooses their actions;
both default to slots 0..n-1, so a single environment needs no slot numbers. Batching lets language models and networks
answer for many environments in one call.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

Observation = Mapping[str, Any]
Info = Mapping[str, Any]


@runtime_checkable
class Agent(Protocol):
    """Chooses among the seven actions from observations and the non-privileged part of ``info``.

    An agent whose ``uses_habits`` is False plays the same at every habit level and is evaluated only once.
    """

    name: str
    """Name in tables."""

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Start an episode in the given slots.

        Args:
            infos: the environments' infos at reset, one per slot.
            slots: slot numbers; 0..n-1 by default.
        """
        ...

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """Choose one action for each slot.

        Args:
            observations: the environments' last observations, one per slot.
            infos: their last infos.
            slots: slot numbers; 0..n-1 by default.

        Returns:
            Actions from 0 to 6, in the order of the slots.
        """
        ...
