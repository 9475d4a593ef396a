"""Base of the agents that ask a language model to choose: LGX, PixelNav and L3MVN.

The habits, preceded by the context where one is given, are in the constant part of the prompt, delimited as data, so
that a prefix cache keeps them for a whole episode. At habit level ``context``, before each choice, the habits are
ranked again by what was seen so far, and the constant part is rewritten only if that changes the list. An unusable
answer is replaced by a random candidate (as in LGX and PixelNav) and counted as a fallback.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from models.agents.waypoint import Chosen, WaypointAgent
from ucon.core.errors import ConfigError
from ucon.core.files import canonical_json, sha256_bytes
from ucon.core.fingerprint import fingerprint_of
from ucon.habits.contexts import Context
from ucon.language.choice import Answer, LanguageModel, Question
from ucon.language.phrases import phrase
from ucon.language.prompt import Prompt, habit_block, neutral
from ucon.readers.conditions.condition_reader import counting, default_conditions
from ucon.retrieval.context import ContextHabits
from ucon.search import Decision, Manner
from ucon.task.agent import Info

PROMPTS = Path(__file__).parent / "prompts"


class AskingAgent(WaypointAgent):
    """Turns decisions into questions to a language model, and its answers into choices.

    A subclass defines :meth:`strategy`, :meth:`questions` and, if answers are not simply candidates, :meth:`conclude`.
    """

    def __init__(
        self, language: LanguageModel, prompt: str, manner: Manner, seed: int = 0, temperature: float = 0.0
    ) -> None:
        """Set up the agent.

        Args:
            language: the language model.
            prompt: name of a file in ``models/agents/prompts/``, or a path.
            manner: how choices are carried out.
            seed: of random choices.
            temperature: 0 takes the best option; above 0, options are drawn from the softmax of ``scores /
                temperature``, where the model gives scores (LGX samples its answers at 0.7).

        Raises:
            ConfigError: a negative temperature, or a prompt file that does not fit.
        """
        super().__init__(manner, seed)
        if temperature < 0.0:
            raise ConfigError(f"temperature={temperature}, expected 0 or more")
        self.language = language
        self.prompt = Prompt.load(path if (path := PROMPTS / f"{prompt}.txt").is_file() else prompt)
        self._temperature = temperature
        self._constant_prompt: dict[int, tuple[str, tuple[str, ...], str]] = {}
        self._rankings: dict[int, ContextHabits | None] = {}
        self._told: dict[int, Context | None] = {}
        self._valid: dict[int, NDArray[np.float64] | None] = {}
        self._habit_weights: dict[int, tuple[float, ...]] = {}

    def check(self) -> None:
        """Raise a one-line error if the model's weights or its server's key are missing."""
        self.language.check()

    def fingerprint(self) -> str | None:
        """Hash of the local model's weights and of the prompt; None where the weights are missing.

        See :mod:`ucon.evaluation.playing.needed_weights`.
        """
        weights = fingerprint_of(self.language)
        return None if weights is None else sha256_bytes(canonical_json([weights, dict(self.prompt.parts)]).encode())

    def start(self, slot: int, info: Info) -> None:
        """Write the constant part of the prompt for the episode in a slot.

        Args:
            slot: of the episode.
            info: of its reset; has the target and the habits.
        """
        self._rankings[slot], self._told[slot] = info.get("reranking"), info.get("told")
        self._valid[slot] = info.get("habits_valid")
        self._write_constant_prompt(slot, phrase(str(info["target"])), tuple(info["habits"]))

    def _write_constant_prompt(self, slot: int, target: str, habits: tuple[str, ...]) -> None:
        """Write the constant part of a slot's prompt."""
        told = self._told[slot]
        counts = counting(default_conditions(), habits, "language", told, self._valid[slot])
        self._habit_weights[slot] = () if counts is None else tuple(counts.tolist())
        now = [] if told is None else [neutral(told.sentence())]
        values = {"target": target, "habits": "\n\n".join([*now, *filter(None, [habit_block(habits)])])}
        self._constant_prompt[slot] = target, habits, self.prompt.system(**_values_for(self.prompt, "system", values))

    def _update_habits(self, decision: Decision, slot: int) -> None:
        """At level ``context``: rank the habits by what was seen, and rewrite the prompt if the list changed."""
        ranking = self._rankings.get(slot)
        if ranking is not None and ranking.update(decision.known.instances.keys(), {}):
            self._write_constant_prompt(slot, self._constant_prompt[slot][0], ranking.texts)

    def situation(self, **slots: str) -> str:
        """The variable part of the prompt.

        Args:
            slots: values by the name of a slot; those without a slot in the prompt file are left out.
        """
        return self.prompt.situation(**_values_for(self.prompt, "situation", slots))

    def cloze(self, **slots: str) -> str:
        """The sentence with a gap, for masked language models; "" where the prompt file has none.

        Args:
            slots: values by the name of a slot; those without a slot in the prompt file are left out.
        """
        wanted = _values_for(self.prompt, "cloze", slots) if "cloze" in self.prompt.parts else {}
        return self.prompt.cloze(**wanted)

    def choose(self, decisions: Sequence[Decision], slots: Sequence[int]) -> list[Chosen]:
        """Choose in all decisions, with one call of the language model; a single candidate is taken without asking.

        Args:
            decisions: one for each slot where a choice is due.
            slots: of the decisions.
        """
        for decision, slot in zip(decisions, slots, strict=True):
            self._update_habits(decision, slot)
        asked = [self.questions(d, s) if len(d.candidates) > 1 else [] for d, s in zip(decisions, slots, strict=True)]
        answers = self.language.answer([question for questions in asked for question in questions])
        out, first = [], 0
        for decision, questions in zip(decisions, asked, strict=True):
            part = answers[first : first + len(questions)]
            first += len(questions)
            out.append(self.conclude(decision, questions, part) if questions else Chosen(0))
        return out

    def questions(self, decision: Decision, slot: int) -> list[Question]:
        """Questions about one decision with two or more candidates; [] takes the first candidate without asking.

        Args:
            decision: what can be chosen, and the map.
            slot: of the decision.
        """
        raise NotImplementedError

    def conclude(self, decision: Decision, questions: Sequence[Question], answers: Sequence[Answer]) -> Chosen:
        """The choice that follows from the answers.

        By default the options of the only question are the candidates, and its answer is the choice.

        Args:
            decision: what can be chosen.
            questions: as :meth:`questions` gave them, at least one.
            answers: one for each question.
        """
        answer, options = answers[0], tuple(option.name for option in questions[0].options)
        number, fallback = self.pick(answer, len(options), decision.draw)
        return Chosen(number, options, answer.scores, (answer,), fallback, -1 if fallback else number)

    def pick(self, answer: Answer, n: int, draw: np.random.Generator) -> tuple[int, bool]:
        """Option that an answer means.

        Args:
            answer: of the language model; its choice is -1 where it was unusable.
            n: number of options.
            draw: random generator of the decision.

        Returns:
            Index of the option, and whether it was drawn at random because the answer was unusable.
        """
        if not 0 <= answer.choice < n:
            return int(draw.integers(n)), True
        if self._temperature > 0.0 and answer.scores:
            weights = np.exp((np.array(answer.scores) - max(answer.scores)) / self._temperature)
            return int(draw.choice(n, p=weights / weights.sum())), False
        return answer.choice, False


def _values_for(prompt: Prompt, part: str, slots: Mapping[str, str]) -> dict[str, str]:
    """The values that a part of the prompt has slots for."""
    names = prompt.slots(part)
    return {name: value for name, value in slots.items() if name in names}


def listed(things: Sequence[tuple[str, int]], most: int = 20) -> str:
    """Things with their counts as text, such as ``sofa, 3 x chair, tv``; ``nothing`` for none.

    Args:
        things: category and count.
        most: longest list.
    """
    names = [phrase(name) if count == 1 else f"{count} x {phrase(name)}" for name, count in things[:most]]
    return ", ".join(names) or "nothing"
