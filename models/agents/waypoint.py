"""Base of agents that choose where to look next: an explorer walks in each slot, one method chooses for all slots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from models.agents.base import slots_of
from ucon.core.errors import ConfigError
from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.language.choice import Answer
from ucon.search import Decision, Explorer, Manner, Strategy
from ucon.search.aims import candidate_words
from ucon.task.agent import Info, Observation


@dataclass(frozen=True, slots=True)
class Chosen:
    """The chosen candidate of a decision, and how it was chosen; stored in ``decisions.jsonl``.

    Args:
        number: index of the candidate.
        options: names of the options, where they are not the candidates.
        scores: one for each option, or none.
        answers: of the language model, if it was asked.
        fallback: True where an unusable answer was replaced at random.
        answered: index of the answered option; -1 where none was.
    """

    number: int
    options: tuple[str, ...] = ()
    scores: tuple[float, ...] = ()
    answers: tuple[Answer, ...] = ()
    fallback: bool = False
    answered: int = -1


class WaypointAgent:
    """Walks to chosen candidates. A subclass defines them (:meth:`strategy`) and chooses (:meth:`choose`)."""

    name = "waypoint"
    uses_habits = True

    def __init__(self, manner: Manner | None = None, seed: int = 0) -> None:
        """Set up the agent.

        Args:
            manner: how choices are carried out: looking around, opening, replanning.
            seed: of random choices.
        """
        self._manner, self._seed = manner or Manner(), seed
        self._explorers: dict[int, Explorer] = {}
        self._episodes: dict[int, str] = {}
        self._decided: dict[int, list[DecisionRecord]] = {}

    def strategy(self, info: Info) -> Strategy:
        """What the candidates of an episode are, such as frontiers or views.

        Args:
            info: of its reset.
        """
        raise NotImplementedError

    def start(self, slot: int, info: Info) -> None:
        """Called at the start of an episode, for what a subclass stores about it.

        Args:
            slot: of the episode.
            info: of its reset.
        """

    def choose(self, decisions: Sequence[Decision], slots: Sequence[int]) -> list[Chosen]:
        """Choose a candidate in each decision.

        A number out of range makes :meth:`act` raise :class:`ConfigError`.

        Args:
            decisions: one for each slot where a choice is due.
            slots: of the decisions.
        """
        raise NotImplementedError

    def reset(self, infos: Sequence[Info], slots: Sequence[int] | None = None) -> None:
        """Start episodes in some slots, with an empty map each.

        Args:
            infos: of the environments' resets.
            slots: their numbers; None: the first ones.
        """
        for slot, info in zip(slots_of(infos, slots), infos, strict=True):
            self._explorers[slot] = Explorer(info, self.strategy(info), self._manner, self._seed)
            self._episodes[slot] = str(info.get("episode", ""))
            self._decided[slot] = []
            self.start(slot, info)

    def act(
        self, observations: Sequence[Observation], infos: Sequence[Info], slots: Sequence[int] | None = None
    ) -> list[int]:
        """The next action in some slots; all choices that are due are made together.

        Args:
            observations: one for each slot.
            infos: one for each slot.
            slots: their numbers; None: the first ones.

        Returns:
            Actions from 0 to 6, in the order of the slots.

        Raises:
            ConfigError: a subclass chose a candidate that does not exist.
        """
        numbers = list(slots_of(infos, slots))
        actions = {
            slot: self._explorers[slot].look(observation, info)
            for slot, observation, info in zip(numbers, observations, infos, strict=True)
        }
        due = [slot for slot in numbers if actions[slot] is None]
        if due:
            decisions = [self._explorers[slot].decision() for slot in due]
            for slot, decision, chosen in zip(due, decisions, self.choose(decisions, due), strict=True):
                _check(self.name, chosen, len(decision.candidates))
                self._decided[slot].append(_record(self._episodes[slot], decision, chosen))
                actions[slot] = self._explorers[slot].choose(chosen.number)
        return [int(actions[slot]) for slot in numbers]  # type: ignore[arg-type]

    def decisions(self, slot: int) -> list[DecisionRecord]:
        """Decisions in a slot since its reset."""
        return self._decided.get(slot, [])

    def language_usage(self, slot: int) -> tuple[int, int, float]:
        """Calls, tokens and seconds of the language model in a slot since its reset."""
        made = self.decisions(slot)
        tokens = sum(d.prompt_tokens + d.completion_tokens for d in made)
        return sum(d.asked for d in made), tokens, sum(d.seconds for d in made)


def _check(name: str, chosen: Chosen, n: int) -> None:
    """Raise :class:`ConfigError` for a choice outside ``n`` candidates, or a wrong number of scores."""
    if not 0 <= chosen.number < n:
        raise ConfigError(f"agent {name} chose number {chosen.number} of {n} candidates, which count from 0")
    options = len(chosen.options) or n
    if chosen.scores and len(chosen.scores) != options:
        raise ConfigError(f"agent {name} gives {len(chosen.scores)} scores for {options} options")


def _record(episode: str, decision: Decision, chosen: Chosen) -> DecisionRecord:
    names = chosen.options or tuple(candidate_words(decision.known, one) for one in decision.candidates)
    candidate = decision.candidates[chosen.number]
    record = DecisionRecord(
        episode, decision.number, decision.step, candidate.kind, names, chosen.number, chosen.scores
    )
    answers = chosen.answers
    return replace(
        record,
        asked=len(answers),
        fallback=chosen.fallback,
        answered=chosen.answered,
        dropped=max((a.dropped for a in answers), default=0),
        failure=next((a.failure for a in answers if a.failure), ""),
        retries=sum(a.retries for a in answers),
        prompt_tokens=sum(a.prompt_tokens for a in answers),
        completion_tokens=sum(a.completion_tokens for a in answers),
        text=answers[0].text if len(answers) == 1 else "",
        places=answers[0].places if len(answers) == 1 else (),
        seconds=sum(a.seconds for a in answers),
    )
