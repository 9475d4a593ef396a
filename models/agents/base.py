"""Agents (:class:`ucon.task.agent.Agent`) made of one independent controller for each environment of the batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.task.agent import Info, Observation


class Controller(Protocol):
    """Plays one episode in one environment."""

    def act(self, observation: Observation, info: Info) -> int:
        """The next action (0..6)."""
        ...


class ControllerAgent:
    """An agent made of one independent controller a slot, which a subclass makes in :meth:`start`."""

    name = "controllers"

    def __init__(self) -> None:
        self.controllers: dict[int, Controller] = {}

    def start(self, info: Info) -> Controller:
        """A fresh controller for the episode whose first ``info`` is given."""
        raise NotImplementedError

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """See :class:`ucon.task.agent.Agent`."""
        for slot, info in zip(slots_of(infos, slots), infos, strict=True):
            self.controllers[slot] = self.start(info)

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """See :class:`ucon.task.agent.Agent`."""
        return [
            self.controllers[slot].act(observation, info)
            for slot, observation, info in zip(slots_of(infos, slots), observations, infos, strict=True)
        ]

    def decisions(self, slot: int) -> list[DecisionRecord]:
        """What was chosen in a slot since its reset; [] where nothing is chosen but actions."""
        return list(getattr(self.controllers[slot], "decisions", ()))

    def picture(self, slot: int) -> NDArray[np.uint8] | None:
        """For videos: what it thinks after its last action in a slot, (384, W, 3); None where it shows nothing."""
        drawn = getattr(self.controllers[slot], "picture", None)
        return None if drawn is None else drawn()


def slots_of(infos: Sequence[Info], slots: Sequence[int] | None) -> Sequence[int]:
    """The slots meant: those given, or the first ones."""
    return range(len(infos)) if slots is None else slots
