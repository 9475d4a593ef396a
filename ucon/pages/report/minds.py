"""Runs an agent alongside a record, to find out what it believed and what it asked a language model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.language.choice import Answer, LanguageModel, Question
from ucon.search.thoughts import Thoughts
from ucon.task.agent import Agent

#: Longest text of a prompt or an answer that is shown, characters.
_MOST_TEXT: Final = 20_000


class HeardModel:
    """A language model whose questions and answers are recorded.

    Attributes:
        said: system message, user message and answer of each question since the last :meth:`take`.
    """

    def __init__(self, model: LanguageModel) -> None:
        self._model = model
        self.said: list[tuple[str, str, str]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._model, name)

    def answer(self, questions: Sequence[Question]) -> list[Answer]:
        """The model's answers, which are recorded."""
        answers = list(self._model.answer(questions))
        for question, answer in zip(questions, answers, strict=True):
            said = answer.text or (question.options[answer.choice].name if answer.choice >= 0 else "no usable answer")
            self.said.append((question.system[:_MOST_TEXT], question.situation[:_MOST_TEXT], said[:_MOST_TEXT]))
        return answers

    def take(self) -> list[tuple[str, str, str]]:
        """What was said since the last call."""
        said, self.said = self.said, []
        return said


class Minds:
    """What an agent thinks while it takes the recorded actions.

    Attributes:
        same: whether its actions have been the recorded ones so far.
        beliefs: step, things (category, box in world metres, share) and goal (x, y in world metres, or None), each time
            that they changed.
        others: by step, the other views that could have been chosen: aim, and gain over cost in words.
        asked: by step, what a language model was asked and what it answered.
        relevance: by given habit, how much it says about the place.
    """

    def __init__(self, agent: Agent | None, start_xy: tuple[float, float], heading: int) -> None:
        """Begin an episode.

        Args:
            agent: the agent that runs alongside; None: nothing is noted.
            start_xy: position of the agent's first pose, metres in the world frame.
            heading: heading of the same pose, quarter turns.
        """
        self.agent, self._start_xy, self._heading = agent, start_xy, heading
        self.same = True
        self.beliefs: list[list[Any]] = []
        self.others: dict[int, Sequence[tuple[str, str]]] = {}
        self.asked: dict[int, list[tuple[str, str, str]]] = {}
        self.relevance: list[float] = []

    def begin(self, info: Any) -> None:
        """Reset the agent with the info of the environment's reset."""
        if self.agent is not None:
            self.agent.reset([info], [0])

    def act(self, observation: Any, info: Any, recorded: int, step: int) -> None:
        """Let the agent act, and note its thoughts; once its action differs from the recorded one, it is dropped.

        Args:
            observation: of the step.
            info: of the step.
            recorded: the recorded action.
            step: number of actions before.
        """
        if self.agent is None:
            return
        (action,) = self.agent.act([observation], [info], [0])
        heard = getattr(self.agent, "language", None)
        if isinstance(heard, HeardModel) and (said := heard.take()):
            self.asked[step] = said
        if int(action) != recorded:
            self.same, self.agent = False, None
            return
        think = getattr(self.agent, "thoughts", None)
        if think is not None and (thoughts := think(0)) is not None:
            self._note(thoughts, step)

    def _note(self, thoughts: Thoughts, step: int) -> None:
        if thoughts.others:
            self.others[step] = thoughts.others
        self.relevance = [round(share, 3) for share in thoughts.relevance]
        things = [[t.category, self._box(t.box), round(t.share, 3)] for t in thoughts.things]
        goal = None if thoughts.goal is None else self._point(*thoughts.goal)
        if not self.beliefs or self.beliefs[-1][1:] != [things, goal]:
            self.beliefs.append([step, things, goal])

    def _point(self, ahead: float, left: float) -> list[float]:
        """World position of a point in the start frame, metres."""
        c, s = HEADING_COS[self._heading], HEADING_SIN[self._heading]
        x, y = self._start_xy
        return [round(float(x + c * ahead - s * left), 2), round(float(y + s * ahead + c * left), 2)]

    def _box(self, box: Sequence[float]) -> list[float]:
        a, b = self._point(box[0], box[1]), self._point(box[2], box[3])
        return [min(a[0], b[0]), min(a[1], b[1]), max(a[0], b[0]), max(a[1], b[1])]
