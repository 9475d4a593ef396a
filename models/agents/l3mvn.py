"""``l3mvn``: goes to the frontier near which a language model expects the target (Yu, Kasaei and Cao, IROS 2023).

On a 5 cm map it finds at most four frontiers and ranks them by utility (size and nearness). For each frontier with
things near it, the model gives the probability of the target in "a room containing" these things, among a set of
labels. A frontier whose probability is clearly above chance is taken; else the first by utility that is not clearly
below chance. The target is approached as soon as a pixel of it is mapped.

Differences from the paper and its code, and their reasons:
- Labels are the target and 19 other categories drawn once from the catalogue; L3MVN has its six targets. With hundreds
  of targets there is no fixed head to train, so this is the zero-shot form. Its thresholds (0.3 and 0.1 of six labels)
  are scaled by the number of labels.
- Habits precede the sentence, as many as fit, since there is no prompt.
- Walking uses the planner that all agents share. A choice is due on arrival, or after 10 actions as in the code.
- It turns through four headings at the start and on arrival, which L3MVN does not (``look_around``).
- The square around a frontier whose things are listed is 4 m wide, as in the zero-shot form (6 m with a trained head;
  ``square_m``).
- The first frontier found counts as well; L3MVN's loop skips one.
- It opens containers on arrival, which L3MVN cannot (``opens``).
- Without a frontier it goes to a random place, as L3MVN does.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from models.agents.asking import AskingAgent
from models.agents.waypoint import Chosen
from ucon.core.errors import ConfigError
from ucon.language.choice import Answer, LanguageModel, Option, Question
from ucon.language.labels import label_set
from ucon.language.phrases import phrase
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.fine_frontiers import SQUARE_M
from ucon.search import Decision, FineFrontiers, Manner, Strategy
from ucon.task.agent import Info

#: Number of labels in L3MVN; its thresholds are for that number.
LABELS_THERE = 6
MOST_THINGS = 20


class L3MVNAgent(AskingAgent):
    """Chooses frontiers by utility and by the target's probability near them."""

    name = "l3mvn"

    def __init__(
        self,
        language: LanguageModel,
        *,
        sure: float = 0.3,
        possible: float = 0.1,
        n_labels: int = 20,
        square_m: float = SQUARE_M,
        replan_steps: int = 10,
        look_around: bool = True,
        opens: bool = True,
        seed: int = 0,
        prompt: str = "l3mvn",
    ) -> None:
        """Set up the agent; :class:`models.agents.asking.AskingAgent` has the rest.

        Args:
            language: the language model; has to give scores.
            sure: a best frontier above this probability (scaled to six labels) is taken.
            possible: otherwise, the first frontier by utility above this probability is taken.
            n_labels: size of the label set.
            square_m: side of the square around a frontier whose things are listed, in metres.
            replan_steps: actions after which it chooses again; 0: only on arrival.
            look_around: turn through four headings at the start and on arrival (L3MVN's camera sees less at once: 79
                degrees).
            opens: open a closed container on arrival.
            seed: of random choices.
            prompt: name of the prompt's file.

        Raises:
            ConfigError: the model gives no scores.
        """
        if not language.gives_scores:
            raise ConfigError(
                f"agent l3mvn compares probabilities, but {language.name} gives none; choose language=encoder, "
                "masked_lm or causal_lm"
            )
        manner = Manner(look_around=look_around, opens=opens, replan_steps=replan_steps)
        super().__init__(language, prompt, manner, seed)
        self._sure, self._possible, self._n_labels, self._square_m = sure, possible, n_labels, square_m

    def strategy(self, info: Info) -> Strategy:
        """Candidates of an episode: frontiers of the 5 cm map, in order of decreasing utility."""
        return FineFrontiers(Body.of(info), self._square_m)

    def questions(self, decision: Decision, slot: int) -> list[Question]:
        """One question for each frontier that has things near it.

        Args:
            decision: has the frontiers as candidates.
            slot: of the decision.
        """
        target, habits, system = self._constant_prompt[slot]
        weights = self._habit_weights[slot]
        options = tuple(Option(name, (name,)) for name in label_set(decision.target, self._n_labels))
        out = []
        for candidate in decision.candidates:
            things = tuple(phrase(name) for name, _ in candidate.things[:MOST_THINGS])
            if things:
                told = partial(self._situation_in, target, ", ".join(things), options)
                cloze = self.cloze(target=target, things=", ".join(things))
                situation = told(range(len(options)))
                out.append(
                    Question(
                        target, habits, options, system, situation, cloze, listed=told, things=things, weights=weights
                    )
                )
        return out

    def _situation_in(self, target: str, things: str, options: Sequence[Option], order: Sequence[int]) -> str:
        return self.situation(target=target, things=things, options=", ".join(options[k].name for k in order))

    def conclude(self, decision: Decision, questions: Sequence[Question], answers: Sequence[Answer]) -> Chosen:
        """The frontier that L3MVN's rule chooses.

        A frontier without things near it scores 0.1 to 0.2, by its utility.

        Args:
            decision: has the frontiers as candidates.
            questions: as :meth:`questions` gave them.
            answers: one for each question; log-probabilities as scores.
        """
        utility = [candidate.utility for candidate in decision.candidates]
        described = iter(answers)
        scores, fallback = [], False
        for candidate, rate in zip(decision.candidates, utility, strict=True):
            answer = next(described) if candidate.things else None
            if answer is not None and answer.scores:
                scores.append(float(np.exp(answer.scores[0])) * len(answer.scores) / LABELS_THERE)
            else:
                fallback |= answer is not None
                scores.append(0.1 + 0.1 * rate / max(*utility, 1e-9))
        number = select(scores, self._sure, self._possible)
        return Chosen(number, scores=tuple(round(s, 4) for s in scores), answers=tuple(answers), fallback=fallback)


def select(scores: Sequence[float], sure: float, possible: float) -> int:
    """Index of the chosen frontier: the best one if above ``sure``, else the first above ``possible``, else the first.

    Args:
        scores: probabilities scaled to six labels, in order of decreasing utility.
        sure: threshold of the best frontier.
        possible: threshold of the others.
    """
    best = int(np.argmax(scores))
    if scores[best] > sure:
        return best
    return next((k for k, score in enumerate(scores) if score > possible), 0)
