"""``l3mvn``: goes to the frontier near which a language model expects the target (Yu, Kasaei and Cao, IROS 2023).

On a 5 cm map it finds at most four frontiers, rated by their size and nearness. For each that has things near it, the
model is asked how probable the target is in "a room containing" these, among a set of labels. A frontier whose
probability is clearly above chance is taken; otherwise the first, in the order of utility, that is not below it. The
target is taken as soon as a pixel of it is mapped.

What differs from the paper and its code, and why. The label set is the target and 19 other categories drawn once from
the catalogue, where L3MVN has its six targets: hundreds of targets leave no fixed head to train, so this is the
zero-shot form, and its thresholds (0.3 and 0.1 of six labels) are scaled by the number of labels. Habits are put before
the sentence, as many as fit, since there is no prompt. Walking is by the planner that all agents share; a choice is due
on arrival, or after 10 actions as in the code. It turns through four headings at the start and on arrival, which L3MVN
does not (``look_around``); the square around a frontier whose things are told is 4 m wide, as in its zero-shot form (6
m with a trained head; ``square_m``). The first frontier found counts as well (its loop skips one). Open on arrival,
which L3MVN has not (``opens``). Where there is no frontier it goes to a random place, as L3MVN does.
"""

from __future__ import annotations

from collections.abc import Sequence

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

#: L3MVN's number of labels, to which its thresholds belong.
LABELS_THERE = 6
MOST_THINGS = 20


class L3MVNAgent(AskingAgent):
    """Frontiers by utility and by what a language model expects behind them."""

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
        """Describe the agent; see :class:`models.agents.asking.AskingAgent` for the rest.

        Args:
            language: answers; must give scores.
            sure: above it the best frontier is taken, by its probability among six labels.
            possible: above it the first frontier in order of utility is taken.
            n_labels: size of the label set.
            square_m: side of the square around a frontier whose things are told.
            replan_steps: actions after which a new choice is due; 0: on arrival only.
            look_around: turn through four headings at the start and on arrival (L3MVN sees less at once: 79 degrees).
            opens: Open on arrival.
            seed: of what is drawn at random.
            prompt: its file.

        Raises:
            ConfigError: the model only names an option.
        """
        if not language.gives_scores:
            raise ConfigError(
                f"agent l3mvn compares probabilities, and {language.name} gives none; choose language=encoder, "
                "masked_lm or causal_lm"
            )
        manner = Manner(look_around=look_around, opens=opens, replan_steps=replan_steps)
        super().__init__(language, prompt, manner, seed)
        self._sure, self._possible, self._n_labels, self._square_m = sure, possible, n_labels, square_m

    def strategy(self, info: Info) -> Strategy:
        """See :class:`models.agents.waypoint.WaypointAgent`."""
        return FineFrontiers(Body.of(info), self._square_m)

    def questions(self, decision: Decision, slot: int) -> list[Question]:
        """One question for each frontier that has things near it."""
        target, habits, system = self._told[slot]
        options = tuple(Option(name, (name,)) for name in label_set(decision.target, self._n_labels))
        names = ", ".join(option.name for option in options)
        out = []
        for candidate in decision.candidates:
            things = tuple(phrase(name) for name, _ in candidate.things[:MOST_THINGS])
            if things:
                told = ", ".join(things)
                situation = self.situation(target=target, things=told, options=names)
                cloze = self.cloze(target=target, things=told)
                out.append(Question(target, habits, options, system, situation, cloze, things=things))
        return out

    def conclude(self, decision: Decision, questions: Sequence[Question], answers: Sequence[Answer]) -> Chosen:
        """The frontier by L3MVN's rule."""
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
    """The best frontier if it is sure, else the first possible one, else the first; they come by falling utility."""
    best = int(np.argmax(scores))
    if scores[best] > sure:
        return best
    return next((k for k, score in enumerate(scores) if score > possible), 0)
