"""Agents that ask a language model to choose: what LGX, PixelNav and L3MVN have in common.

The habits are in the constant part of the prompt, delimited as data, so that a prefix cache keeps them for an episode.
At habit level ``context`` the list is told what was seen before each choice, and the part is written anew where that
changed the list.
An answer that cannot be used is replaced by a candidate drawn at random (as LGX and PixelNav do), and counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from models.agents.waypoint import Chosen, WaypointAgent
from ucon.core.errors import ConfigError
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.language.choice import Answer, LanguageModel, Question
from ucon.language.phrases import phrase
from ucon.language.prompt import Prompt, habit_block
from ucon.retrieval.context import ContextHabits
from ucon.search import Decision, Manner
from ucon.task.agent import Info

PROMPTS = Path(__file__).parent / "prompts"


class AskingAgent(WaypointAgent):
    """A subclass turns a decision into questions and answers into a choice."""

    def __init__(
        self, language: LanguageModel, prompt: str, manner: Manner, seed: int = 0, temperature: float = 0.0
    ) -> None:
        """Describe the agent.

        Args:
            language: answers.
            prompt: name of a file in ``models/agents/prompts/``, or a path.
            manner: how choices are carried out.
            seed: of what is drawn at random.
            temperature: 0 takes the best option; above it, options are drawn by ``scores / temperature``, where the
                model gives scores (LGX samples its answers at 0.7).
        """
        super().__init__(manner, seed)
        if temperature < 0.0:
            raise ConfigError(f"temperature={temperature}, expected 0 or more")
        self.language = language
        self.prompt = Prompt.load(path if (path := PROMPTS / f"{prompt}.txt").is_file() else prompt)
        self._temperature = temperature
        self._told: dict[int, tuple[str, tuple[str, ...], str]] = {}
        self._rankings: dict[int, ContextHabits | None] = {}

    def check(self) -> None:
        """Fail in one line where the model's weights or its server's key are missing."""
        self.language.check()

    def fingerprint(self) -> str | None:
        """The model's weights here and what it is asked with; see :mod:`ucon.evaluation.playing.needed_weights`."""
        weights = fingerprint_of(self.language)
        return None if weights is None else sha256_bytes(canonical_json([weights, dict(self.prompt.parts)]).encode())

    def start(self, slot: int, info: Info) -> None:
        """Write the part of the prompt that stays."""
        self._rankings[slot] = info.get("reranking")
        self._tell(slot, phrase(str(info["target"])), tuple(info["habits"]))

    def _tell(self, slot: int, target: str, habits: tuple[str, ...]) -> None:
        told = {"target": target, "habits": habit_block(habits)}
        self._told[slot] = target, habits, self.prompt.system(**_wanted(self.prompt, "system", told))

    def _reread(self, decision: Decision, slot: int) -> None:
        """At level ``context``: say which things were seen, and take the list that comes of it."""
        ranking = self._rankings.get(slot)
        if ranking is not None and ranking.update(decision.known.instances.keys(), {}):
            self._tell(slot, self._told[slot][0], ranking.texts)

    def situation(self, **slots: str) -> str:
        """The part of the prompt that changes; what its file has no slot for is left out."""
        return self.prompt.situation(**_wanted(self.prompt, "situation", slots))

    def cloze(self, **slots: str) -> str:
        """The sentence with a gap; empty where the prompt has none."""
        wanted = _wanted(self.prompt, "cloze", slots) if "cloze" in self.prompt.parts else {}
        return self.prompt.cloze(**wanted)

    def choose(self, decisions: Sequence[Decision], slots: Sequence[int]) -> list[Chosen]:
        """Ask about all decisions at once; where there is one candidate only, nothing is asked."""
        for decision, slot in zip(decisions, slots, strict=True):
            self._reread(decision, slot)
        asked = [self.questions(d, s) if len(d.candidates) > 1 else [] for d, s in zip(decisions, slots, strict=True)]
        answers = self.language.answer([question for questions in asked for question in questions])
        out, first = [], 0
        for decision, questions in zip(decisions, asked, strict=True):
            part = answers[first : first + len(questions)]
            first += len(questions)
            out.append(self.conclude(decision, questions, part) if questions else Chosen(0))
        return out

    def questions(self, decision: Decision, slot: int) -> list[Question]:
        """What to ask about a decision of two candidates or more; [] chooses the first without asking."""
        raise NotImplementedError

    def conclude(self, decision: Decision, questions: Sequence[Question], answers: Sequence[Answer]) -> Chosen:
        """The choice that follows; by default that of the only answer, whose options are the candidates."""
        answer, options = answers[0], tuple(option.name for option in questions[0].options)
        number, fallback = self.pick(answer, len(options), decision.draw)
        return Chosen(number, options, answer.scores, (answer,), fallback, -1 if fallback else number)

    def pick(self, answer: Answer, n: int, draw: np.random.Generator) -> tuple[int, bool]:
        """The option that an answer means, and whether it had to be drawn blindly."""
        if not 0 <= answer.choice < n:
            return int(draw.integers(n)), True
        if self._temperature > 0.0 and answer.scores:
            heat = np.exp((np.array(answer.scores) - max(answer.scores)) / self._temperature)
            return int(draw.choice(n, p=heat / heat.sum())), False
        return answer.choice, False


def _wanted(prompt: Prompt, part: str, slots: Mapping[str, str]) -> dict[str, str]:
    names = prompt.slots(part)
    return {name: value for name, value in slots.items() if name in names}


def listed(things: Sequence[tuple[str, int]], most: int = 20) -> str:
    """Things as prose, ``sofa, 3 chairs, tv``; ``nothing`` where there are none."""
    names = [phrase(name) if count == 1 else f"{count} x {phrase(name)}" for name, count in things[:most]]
    return ", ".join(names) or "nothing"
