"""The last part of every search: walk up to the thing that was found, face it, say Done."""

from __future__ import annotations

from collections import deque
from typing import ClassVar

from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap
from ucon.perception.views.approach import Approach
from ucon.task.actions import Action


class Homing(PartlyShared):
    """Takes an agent to one track. The same for all agents, so that they differ in searching alone."""

    _flat: ClassVar[frozenset[str]] = frozenset({"_plan"})

    REPLAN_STEPS = 5

    def __init__(self) -> None:
        self.approach = Approach()
        self._plan: deque[Action] = deque()
        self._age = 0
        self._under_way = False

    def act(self, known: SemanticMap, planner: Planner, track: int, *, blocked: bool = False) -> Action:
        """The next action; ``blocked``: the last move failed."""
        if blocked:
            self._plan.clear()
        if self.approach.arrived(known, track):
            return Action.DONE
        if self._plan and self._age < self.REPLAN_STEPS:
            self._age += 1
            return self._plan.popleft()
        if self._under_way and not self._plan:
            self.approach.failed(known.view)
        self._under_way, self._age = True, 0
        planner.update(known)
        goal = self.approach.goal(known, planner, track) or self.approach.nearer(known, planner, track)
        self._plan = deque(planner.plan(goal))
        return self._plan.popleft() if self._plan else Action.ROTATE_LEFT
