"""The searching controller that ``frontier`` and ``belief`` share: of all views, that of the most gain for its cost."""

from __future__ import annotations

from ucon.evaluation.kept.decisions import DecisionRecord
from ucon.perception.belief.protocol import Expecting
from ucon.perception.drawing.map_picture import Image
from ucon.perception.views.viewpoints import Choice, Costs
from ucon.search.aims import Aim, aim_at_target, aim_of, aim_to_open
from ucon.search.searcher import SearchDecision, Searcher
from ucon.task.actions import Action
from ucon.task.agent import Info, Observation

#: Digits kept of a score.
_DIGITS = 6


class SearchLog:
    """What one search chose, for ``decisions.jsonl``: a line where it goes for something else than before."""

    def __init__(self, info: Info) -> None:
        """``info``: of the reset."""
        self.decisions: list[DecisionRecord] = []
        self._episode = str(info.get("episode", ""))
        self._going: Choice | None = None
        self._taking = False

    def looked(self, searcher: Searcher, action: Action | None) -> None:
        """After a frame: what is done without a choice of views."""
        if searcher.taking:
            if not self._taking:
                self._taking = True
                self._add(searcher, aim_at_target(searcher))
        elif action is Action.OPEN and not self._came_to_open(searcher):
            self._add(searcher, aim_to_open(searcher))

    def chose(self, searcher: Searcher, decision: SearchDecision, choice: Choice | None, also: str = "") -> None:
        """Before the search goes where ``choice`` says; ``also``: more of why."""
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
    """Searches one home for one target."""

    def __init__(self, info: Info, expecting: Expecting, costs: Costs | None = None) -> None:
        self.searcher = Searcher(info, expecting, costs)
        self._log = SearchLog(info)

    def act(self, observation: Observation, info: Info) -> int:
        """The next action."""
        action = self.searcher.look(observation, info)
        self._log.looked(self.searcher, action)
        if action is None:
            decision = self.searcher.decision()
            self._log.chose(self.searcher, decision, decision.best)
            action = self.searcher.choose(decision.best)
        return int(action)

    @property
    def decisions(self) -> list[DecisionRecord]:
        """What it went for so far."""
        return self._log.decisions

    def picture(self) -> Image:
        """What it thinks; see :func:`ucon.search.picture.draw_search`."""
        from ucon.search.picture import draw_search

        return draw_search(self.searcher)
