"""The controller that ``frontier`` and ``belief`` share: goes to the view of the highest expected gain over cost."""

from __future__ import annotations

from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.perception.belief.protocol import Expecting
from ucon.perception.drawing.map_picture import Image
from ucon.perception.views.viewpoints import Choice, Costs
from ucon.search.aims import Aim, aim_at_target, aim_of, aim_to_open
from ucon.search.search_decision import SearchDecision
from ucon.search.searcher import Searcher
from ucon.search.suspects import Judge
from ucon.search.thoughts import Thoughts, thoughts_of
from ucon.task.actions import Action
from ucon.task.agent import Info, Observation

#: Digits of a score in ``decisions.jsonl``.
_DIGITS = 6


class SearchLog:
    """Decisions of one search for ``decisions.jsonl``: one line whenever its goal changes."""

    def __init__(self, info: Info) -> None:
        """Start an empty log.

        Args:
            info: of the reset.
        """
        self.decisions: list[DecisionRecord] = []
        self._episode = str(info.get("episode", ""))
        self._going: Choice | None = None
        self._taking = -1

    def looked(self, searcher: Searcher, action: Action | None) -> None:
        """Record, after a frame, what is done without choosing a view: approaching the target, or opening on the way.

        Args:
            searcher: has processed the frame.
            action: the next one if no view has to be chosen, else None.
        """
        taking = -1 if not searcher.taking else 0 if searcher.doubt is None else searcher.doubt.suspect
        before, self._taking = self._taking, taking
        if taking >= 0:
            if taking != before:
                self._going = None
                self._add(searcher, aim_at_target(searcher))
        elif action is Action.OPEN and not self._came_to_open(searcher):
            self._add(searcher, aim_to_open(searcher))

    def chose(self, searcher: Searcher, decision: SearchDecision, choice: Choice | None, also: str = "") -> None:
        """Record a chosen view before the search goes there; nothing if it is the same as before.

        Args:
            searcher: of the search.
            decision: the views.
            choice: the chosen one; None if no view is left.
            also: text added to the reason.
        """
        going = self._going
        if choice is not None and going is not None and (going.view, going.opens) == (choice.view, choice.opens):
            return
        self._going = choice
        aim = aim_of(searcher, decision, choice)
        score = () if choice is None else (round(choice.score, _DIGITS),)
        self._add(searcher, aim._replace(why=f"{aim.why}{also}"), score)

    def _came_to_open(self, searcher: Searcher) -> bool:
        """Whether the view that was chosen for opening is reached."""
        return self._going is not None and self._going.opens and self._going.view == searcher.map.view

    def _add(self, searcher: Searcher, aim: Aim, scores: tuple[float, ...] = ()) -> None:
        number, step = len(self.decisions), searcher.map.step
        self.decisions.append(
            DecisionRecord(self._episode, number, step, aim.kind, (aim.words,), 0, scores, text=aim.why)
        )


class SearchController:
    """Searches one home for one target.

    Args:
        info: of the reset.
        expecting: gives the expected gain of looking at a place.
        costs: of moves, turns and looks, in actions.
        judge: says how probable suspects are, where the detector errs; None: the arithmetic posterior.

    Attributes:
        searcher: the search.
        decided: what it chose from in its last step; None where there was nothing to choose.
    """

    def __init__(
        self, info: Info, expecting: Expecting, costs: Costs | None = None, judge: Judge | None = None
    ) -> None:
        self.searcher = Searcher(info, expecting, costs, judge=judge)
        self.decided: SearchDecision | None = None
        self._log = SearchLog(info)

    def act(self, observation: Observation, info: Info) -> int:
        """The next action, 0 to 6: continue on the way, or choose the best view and set out.

        Args:
            observation: of the reset or the last step.
            info: of the same.
        """
        action = self.searcher.look(observation, info)
        self._log.looked(self.searcher, action)
        self.decided = None
        if action is None:
            self.decided = decision = self.searcher.decision()
            self._log.chose(self.searcher, decision, decision.best)
            action = self.searcher.choose(decision.best)
        return int(action)

    @property
    def decisions(self) -> list[DecisionRecord]:
        """Decisions so far, one whenever the goal changed."""
        return self._log.decisions

    def thoughts(self) -> Thoughts:
        """Belief, goal and other views after the last action, as plain values."""
        return thoughts_of(self.searcher, self.decided)

    def picture(self) -> Image:
        """Picture of the map and belief, (384, W, 3) uint8; see :func:`ucon.search.picture.draw_search`."""
        from ucon.search.picture import draw_search

        return draw_search(self.searcher)
