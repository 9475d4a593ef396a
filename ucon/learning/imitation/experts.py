"""Experts that say at every step what a policy should have done: one that knows the home, or an agent that searches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from ucon.learning.imitation.demonstrators import agent_fingerprint, check_agent
from ucon.learning.imitation.view_labels import Label, no_views, views_label
from ucon.search.search_decision import SearchDecision, Seeking
from ucon.task.actions import Action
from ucon.task.agent import Agent
from ucon.task.episode import Episode
from ucon.task.expert import Expert

Info = Mapping[str, Any]


@runtime_checkable
class Decides(Protocol):
    """An agent that chooses among views."""

    def decided(self, slot: int) -> tuple[Seeking, SearchDecision | None] | None:
        """The search in a slot, and what it chose from in its last step."""
        ...


class Corrector(Protocol):
    """Follows episodes that a policy plays, in numbered slots, and says what it should do."""

    @property
    def title(self) -> str:
        """The expert in words, for the model card."""
        ...

    def fingerprint(self) -> str:
        """Hash or name of everything besides the episodes that its labels depend on; "" for nothing."""
        ...

    def begin(self, slot: int, episode: Episode, env: Any, info: Info) -> None:
        """Begin an episode in a slot.

        Args:
            slot: number of the slot; its previous episode is over.
            episode: the episode.
            env: the environment that plays it, after the reset.
            info: of the reset.
        """
        ...

    def label(self, slot: int, observation: Info, info: Info) -> Action | None:
        """The action that the policy should take next, wherever it stands; None where the expert knows none.

        Args:
            slot: number of the slot.
            observation: of the frame.
            info: of the frame.
        """
        ...

    def views(self, slot: int) -> Label:
        """Its scores of views when it last gave an action; see :data:`ucon.learning.imitation.view_labels.Label`.

        Args:
            slot: number of the slot.
        """
        ...


class KnowingExpert:
    """Goes the shortest way from wherever the policy stands: it knows the home, the target's place and its container.

    Privileged: a policy cannot know why it goes there.
    """

    title = "an expert that knows where the target is"

    def __init__(self) -> None:
        self._experts: dict[int, tuple[Expert, Any]] = {}

    def fingerprint(self) -> str:
        """Empty: all that it knows is part of the episodes, which have hashes of their own."""
        return ""

    def begin(self, slot: int, episode: Episode, env: Any, info: Info) -> None:
        """See :class:`Corrector`."""
        self._experts[slot] = Expert(episode), env

    def label(self, slot: int, observation: Info, info: Info) -> Action | None:
        """The next action of a shortest solution from here."""
        expert, env = self._experts[slot]
        return expert.action(env.unwrapped.search)

    def views(self, slot: int) -> Label:
        """An empty label: it scores no views."""
        return no_views()


class SearchingExpert:
    """An agent that searches, and is shown the policy's own frames: it knows no more than the policy does.

    Args:
        agent: such as ``habit_policy`` or ``belief``; plays many episodes at once. It must cope with actions being
            taken that it did not choose.

    Raises:
        ConfigError: ``agent`` has no ``reset`` and ``act``.
    """

    def __init__(self, agent: Agent) -> None:
        check_agent(agent, "learner.expert.agent")
        self._agent = agent
        self.title = f"what the agent {agent.name} would do in the same places"

    def fingerprint(self) -> str:
        """Name of the agent and the hash of its weights, if it has any."""
        return agent_fingerprint(self._agent)

    def begin(self, slot: int, episode: Episode, env: Any, info: Info) -> None:
        """See :class:`Corrector`."""
        self._agent.reset([info], [slot])

    def label(self, slot: int, observation: Info, info: Info) -> Action | None:
        """The agent's own next action."""
        return Action(self._agent.act([observation], [info], [slot])[0])

    def views(self, slot: int) -> Label:
        """The agent's scores of views; an empty label where it has none."""
        found = self._agent.decided(slot) if isinstance(self._agent, Decides) else None
        return no_views() if found is None else views_label(*found)
