"""Search with a detector that errs: which thing to walk up to, look at again, take for the target, or give up.

Walking up to a suspect and looking elsewhere are compared by the probability of finding the target over the cost.
Done ends the search at a suspect that is probable enough; near the end of the episode, the best suspect is taken.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.planner import UNREACHED
from ucon.search.another_side import another_side, in_view
from ucon.search.search_decision import Seeking
from ucon.search.suspects import Judge, Suspects
from ucon.task.actions import Action

#: Assumed cost, in actions, of a suspect to which no path is known.
_NO_WAY = 60


@dataclass(frozen=True)
class Doubts(Shared):
    """When suspects are walked up to, taken for the target, and given up."""

    consider: float = 0.03
    """Suspects less probable than this are not walked up to."""
    falls: float = 0.4
    """A suspect is given up when its probability falls below this times the one at which it was chosen."""
    take: float = 0.7
    """Done is called at a suspect that is this probable."""
    settle: float = 0.4
    """The same when no further look is left: no new side to see it from, or ``most_looks`` made."""
    most_looks: int = 3
    """Most further looks at a suspect within reach."""
    last_steps: int = 30
    """When this many steps are left, the best suspect is taken if it is probable enough."""
    last_least: float = 0.2
    """Least probability of a suspect that is taken then."""


class Doubt(PartlyShared):
    """The suspects of one search, and what is done about them.

    Attributes:
        suspects: up to date after :meth:`act`.
        suspect: track that the agent is walking up to; -1 where there is none.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"_plan", "_given_up"})

    def __init__(self, steps: int, judge: Judge | None = None, doubts: Doubts | None = None) -> None:
        """Start an episode.

        Args:
            steps: most steps of the episode.
            judge: gives the probabilities of suspects; None: the arithmetic posterior.
            doubts: thresholds; defaults where None.
        """
        self.suspects = Suspects(judge)
        self.suspect = -1
        self._steps, self._ends = steps, doubts or Doubts()
        self._chosen_at = 0.0
        self._plan: deque[Action] = deque()
        self._looks = 0
        self._given_up: dict[int, int] = {}

    @property
    def p(self) -> dict[int, float]:
        """Probability of each suspect, by track."""
        return self.suspects.p

    @staticmethod
    def looks(search: Seeking) -> dict[int, list[tuple[int, float, float]]]:
        """Looks at each thing found, by track; see :class:`ucon.perception.hypotheses.hypotheses.Hypotheses`."""
        assert search.map.hypotheses is not None
        return search.map.hypotheses.looks

    def act(self, search: Seeking, depth: NDArray[np.float32], blocked: bool) -> Action | None:
        """The next action at or towards a suspect.

        Args:
            search: the search, after it took in a frame.
            depth: (H, W) float32 of the frame, metres.
            blocked: whether the last move failed.

        Returns:
            None where the search continues elsewhere.
        """
        ends = self._ends
        self.suspects.look(search)
        if blocked:
            self._plan.clear()
        left = self._steps - search.map.step
        if left <= ends.last_steps and max(self.p.values(), default=0.0) >= ends.last_least:
            return self._take_best(search, depth, blocked)
        if self.suspect >= 0 and self.p.get(self.suspect, 0.0) < max(ends.consider, ends.falls * self._chosen_at):
            self._give_up(search)
        if self.suspect < 0:
            self._choose(search)
        return None if self.suspect < 0 else self._go_on(search, depth, blocked)

    def _go_on(self, search: Seeking, depth: NDArray[np.float32], blocked: bool) -> Action | None:
        """Walk up to the suspect; within reach, take it, look at it from another side, or give it up."""
        track, p = self.suspect, self.p[self.suspect]
        within_reach = self._within_reach(search, depth, track)
        if within_reach and p >= self._ends.take:
            return Action.DONE
        if self._plan:
            return self._plan.popleft()
        if not within_reach:
            return search.homing.act(search.map, search.planner, track, blocked=blocked)
        view = another_side(search.map, search.planner, track) if self._looks < self._ends.most_looks else None
        self._looks += 1
        if view is not None:
            self._plan = deque(search.planner.plan(view))
        if self._plan:
            return self._plan.popleft()
        if p >= self._ends.settle:
            return Action.DONE
        self._give_up(search)
        return None

    def _take_best(self, search: Seeking, depth: NDArray[np.float32], blocked: bool) -> Action:
        """Walk up to the most probable suspect and call Done."""
        track = max(self.p, key=lambda t: (self.p[t], -t))
        if track != self.suspect:
            self.suspect, self._plan = track, deque()
        if self._within_reach(search, depth, track):
            return Action.DONE
        return search.homing.act(search.map, search.planner, track, blocked=blocked)

    def _give_up(self, search: Seeking) -> None:
        """Give the suspect up; it may be chosen again after further looks at it."""
        self._given_up[self.suspect] = len(self.looks(search)[self.suspect])
        self.suspect, self._looks, self._plan = -1, 0, deque()

    def _choose(self, search: Seeking) -> None:
        """Choose the best suspect, if it is worth more than the best view."""
        looks, expected = self.looks(search), search.expected
        assert expected is not None
        tracks = [
            track
            for track, p in self.p.items()
            if p >= self._ends.consider and len(looks[track]) > self._given_up.get(track, -1)
        ]
        if not tracks:
            return
        decision = search.decision()
        _, costs = search.homing.approach.goals(search.map, search.planner, np.array(tracks, np.int64))
        worth = np.array([self.p[t] for t in tracks]) / (np.where(costs < UNREACHED, costs, _NO_WAY) + 1.0)
        best = int(worth.argmax())
        score = 0.0 if decision.best is None or decision.valued is None else decision.best.score
        if worth[best] >= score / expected.unit:
            self.suspect, self._chosen_at = tracks[best], self.p[tracks[best]]
            self._looks, self._plan = 0, deque()

    @staticmethod
    def _within_reach(search: Seeking, depth: NDArray[np.float32], track: int) -> bool:
        """Whether Done would succeed if the suspect is the target: near enough, and in view (even if not detected)."""
        if not search.homing.approach.near(search.map, track):
            return False
        return bool(search.map.pixels[track] >= MIN_PIXELS) or in_view(search.map, depth, track)
