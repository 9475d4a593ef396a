"""``lgx``: asks a language model which direction to take (Dorbala, Mullen and Manocha, RA-L 2024).

In each round it turns through all headings and approaches the target if one of them shows it. Otherwise it asks one
question, with the things seen in each free direction (``mode="direction"``) or one list of all of them
(``mode="object"``), and walks to a random free node in view in the answered direction. An answered thing means the
first free direction that shows it.

Differences from the paper and its code, and their reasons:
- Four views at 90 degrees instead of thirteen at 30: the task's turns.
- Rounds until the 300 steps of the task are used up, instead of five.
- Labels from the detector in use instead of YOLOv5 and GLIP.
- The prompt lists things by direction and leaves blocked directions out, as the UcON paper describes it; LGX's object
  mode gives one list of everything seen (here: in free directions). Both walk in the thing's direction.
- Walking uses the planner that all agents share.
- Success is the task's (an approach, and Done within 1 m) instead of an oracle's within 2 m.
- It opens containers on arrival, which LGX cannot (``opens``).
- Nothing is remembered between rounds (``memory`` is an addition, off by default).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from models.agents.asking import AskingAgent, listed
from models.agents.waypoint import Chosen
from ucon.core.errors import ConfigError, unknown_name
from ucon.language.choice import Answer, LanguageModel, Option, Question
from ucon.language.phrases import phrase
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.views.candidates import Candidate
from ucon.perception.views.heading_candidates import Goal
from ucon.search import Decision, Manner, Strategy, Views
from ucon.task.agent import Info

Mode = Literal["direction", "object"]
#: Names of directions by the number of headings; the index is the number of turns to the left.
SIDES = {
    4: ("front", "left", "behind", "right"),
    6: ("front", "front left", "back left", "behind", "back right", "front right"),
}


class LGXAgent(AskingAgent):
    """Language-guided exploration: chooses a direction, then a random node that way."""

    name = "lgx"

    def __init__(
        self,
        language: LanguageModel,
        *,
        mode: Mode = "direction",
        goal: Goal = "random",
        reach_m: float = 5.0,
        temperature: float = 0.7,
        memory: bool = False,
        opens: bool = True,
        seed: int = 0,
        prompt: str = "lgx",
    ) -> None:
        """Set up the agent; :class:`models.agents.asking.AskingAgent` has the rest.

        Args:
            language: the language model.
            mode: choose among directions, or among the things seen.
            goal: which of the free nodes in view to walk to.
            reach_m: largest distance of that node, in metres.
            temperature: of the choice, where the model gives scores.
            memory: mark directions that lead to visited nodes.
            opens: open a closed container on arrival.
            seed: of random choices.
            prompt: name of the prompt's file.

        Raises:
            ConfigError: an unknown mode or goal.
        """
        for option, value, choices in (("mode", mode, get_args(Mode)), ("goal", goal, get_args(Goal))):
            if value not in choices:
                raise ConfigError(unknown_name(f"{option} of agent lgx", value, choices))
        if mode == "object" and prompt == "lgx":
            prompt = "lgx_object"
        super().__init__(language, prompt, Manner(opens=opens, interrupt="around"), seed, temperature)
        self._mode, self._goal, self._reach_m, self._memory = mode, goal, reach_m, memory

    def strategy(self, info: Info) -> Strategy:
        """Candidates of an episode: the free directions."""
        return Views(self._goal, most_m=self._reach_m)

    def questions(self, decision: Decision, slot: int) -> list[Question]:
        """One question about the directions, or about the things in them.

        Args:
            decision: has the free directions as candidates.
            slot: of the decision.
        """
        target, habits, system = self._constant_prompt[slot]
        options = self._options(decision)
        lines = [self._line(decision, candidate) for candidate in decision.candidates]
        things = list(dict.fromkeys(name for c in decision.candidates for name, _ in c.things))
        directions = options[0].name in SIDES[decision.known.body.headings]  # else the things are the options

        def told(order: Sequence[int]) -> str:
            of_things, of_lines = (range(len(things)), order) if directions else (order, range(len(lines)))
            return self.situation(
                target=target,
                views="\n".join(lines[k] for k in of_lines),
                things=listed([(things[k], 1) for k in of_things], 99),
                options=", ".join(options[k].name for k in order),
            )

        return [
            Question(
                target=target,
                habits=habits,
                options=options,
                system=system,
                situation=told(range(len(options))),
                cloze=self.cloze(target=target),
                listed=told,
                weights=self._habit_weights[slot],
            )
        ]

    def conclude(self, decision: Decision, questions: Sequence[Question], answers: Sequence[Answer]) -> Chosen:
        """The answered direction; an answered thing means the first direction that shows it.

        Args:
            decision: has the free directions as candidates.
            questions: the one question.
            answers: its answer.
        """
        if self._mode == "direction":
            return super().conclude(decision, questions, answers)
        options = tuple(option.name for option in questions[0].options)
        option, fallback = self.pick(answers[0], len(options), decision.draw)
        shown = [{phrase(name) for name, _ in c.things} | {side_of(decision.known, c)} for c in decision.candidates]
        if fallback:
            number = int(decision.draw.integers(len(shown)))
        else:
            number = next(k for k, names in enumerate(shown) if options[option] in names)
        return Chosen(number, options, answers[0].scores, tuple(answers), fallback, -1 if fallback else option)

    def _options(self, decision: Decision) -> tuple[Option, ...]:
        if self._mode == "object":
            names = dict.fromkeys(phrase(name) for c in decision.candidates for name, _ in c.things)
            if names:
                return tuple(Option(name, (name,)) for name in names)
        return tuple(
            Option(side_of(decision.known, candidate), tuple(phrase(name) for name, _ in candidate.things))
            for candidate in decision.candidates
        )

    def _line(self, decision: Decision, candidate: Candidate) -> str:
        side = side_of(decision.known, candidate)
        line = f"{side}: {listed(candidate.things)}; free for {candidate.free_m:.1f} m"
        was_there = self._memory and decision.known.visited[candidate.view.i, candidate.view.j]
        return f"{line}; you have been there" if was_there else line


def side_of(known: SemanticMap, candidate: Candidate) -> str:
    """Name of a candidate's direction relative to where the agent looks, such as front or left."""
    sides = SIDES[known.body.headings]
    return sides[(candidate.view.heading - known.view.heading) % len(sides)]
