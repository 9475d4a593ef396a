"""Base of agents (:class:`ucon.task.agent.Agent`) with an independent controller for each environment of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.search.search_decision import SearchDecision, Seeking
from ucon.search.thoughts import Thoughts
from ucon.task.agent import Info, Observation


class Controller(Protocol):
    """Plays one episode in one environment."""

    def act(self, observation: Observation, info: Info) -> int:
        """The next action, 0 to 6 (:class:`ucon.task.actions.Action`).

        Args:
            observation: of the reset or the last step.
            info: of the same reset or step.
        """
        ...


class ControllerAgent:
    """An agent with a controller for each slot (environment of the batch); a subclass makes them in :meth:`start`."""

    name = "controllers"

    def __init__(self) -> None:
        self.controllers: dict[int, Controller] = {}

    def start(self, info: Info) -> Controller:
        """A new controller for an episode.

        Args:
            info: of the environment's reset.
        """
        raise NotImplementedError

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Start episodes in some slots.

        Args:
            infos: of the environments' resets.
            slots: their numbers; None: the first ones.
        """
        for slot, info in zip(slots_of(infos, slots), infos, strict=True):
            self.controllers[slot] = self.start(info)

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """The next action in some slots.

        Args:
            observations: one for each slot.
            infos: one for each slot.
            slots: their numbers; None: the first ones.

        Returns:
            Actions from 0 to 6, in the order of the slots.
        """
        return [
            self.controllers[slot].act(observation, info)
            for slot, observation, info in zip(slots_of(infos, slots), observations, infos, strict=True)
        ]

    def decided(self, slot: int) -> tuple[Seeking, SearchDecision | None] | None:
        """The search in a slot and what it chose from in its last step; None for controllers that score no views."""
        controller = self.controllers[slot]
        if not hasattr(controller, "decided"):
            return None
        return controller.searcher, controller.decided  # type: ignore[attr-defined]

    def decisions(self, slot: int) -> list[DecisionRecord]:
        """Decisions in a slot since its reset; [] where the controller only chooses actions."""
        return list(getattr(self.controllers[slot], "decisions", ()))

    def thoughts(self, slot: int) -> Thoughts | None:
        """For reports: what the search in a slot thinks after its last action; None for controllers without belief."""
        think = getattr(self.controllers[slot], "thoughts", None)
        return None if think is None else think()

    def picture(self, slot: int) -> NDArray[np.uint8] | None:
        """For videos: a picture of the agent's state after its last action in a slot.

        Returns:
            (384, W, 3) uint8, or None where the controller draws nothing.
        """
        drawn = getattr(self.controllers[slot], "picture", None)
        return None if drawn is None else drawn()


def slots_of(infos: Sequence[Info], slots: Sequence[int] | None) -> Sequence[int]:
    """Numbers of the slots: those given, or the first ``len(infos)``."""
    return range(len(infos)) if slots is None else slots
