"""``human``: a person chooses the actions, on the page *Play* of ``python -m ucon serve``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from ucon.core.errors import ConfigError
from ucon.task.agent import Info, Observation


class Hand(Protocol):
    """Source of the actions: shows observations to a person and returns the person's answers."""

    def begin(self, info: Info) -> None:
        """An episode begins.

        Args:
            info: of the environment's reset.
        """
        ...

    def choose(self, observation: Observation, info: Info) -> int:
        """Wait for the person's next action, 0 to 6.

        Args:
            observation: of the reset or the last step.
            info: of the same.
        """
        ...


class HumanAgent:
    """Asks a person for every action; one environment at a time.

    Attributes:
        hand: what it asks for actions; None outside the page *Play*.
    """

    name = "human"
    uses_habits = True

    def __init__(self, player: str = "") -> None:
        """Name the person.

        Args:
            player: name or initials; tells the runs of several people apart.
        """
        self.player = player
        self.hand: Hand | None = None

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Show the person a new episode.

        Raises:
            ConfigError: there is nobody to ask, or more than one environment is played at once.
        """
        if self.hand is None:
            raise ConfigError(
                "agent=human: a person searches on the page Play of `python -m ucon serve`; watch a finished game "
                "with `python -m ucon watch RUN EPISODE --actions`"
            )
        if len(infos) != 1 or (slots is not None and list(slots) != [0]):
            raise ConfigError("agent=human: a person plays one episode at a time; leave batch=1")
        self.hand.begin(infos[0])

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """The person's next action, in a list of one."""
        assert self.hand is not None
        return [self.hand.choose(observations[0], infos[0])]
