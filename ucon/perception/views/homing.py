"""The last part of every search: walk up to the thing that was found, face it, and call Done."""

from __future__ import annotations

from collections import deque
from typing import ClassVar

from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap, View
from ucon.perception.views.approach import Approach
from ucon.task.actions import Action


class Homing(PartlyShared):
    """Leads the agent to one track and calls Done.

    All agents share it, so that they differ only in how they search.

    Attributes:
        approach: finds the poses to walk to.
        goal: the pose that the agent is walking to; None before the first plan.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"_plan"})

    REPLAN_STEPS = 5

    def __init__(self) -> None:
        """Start without a plan."""
        self.approach = Approach()
        self.goal: View | None = None
        self._plan: deque[Action] = deque()
        self._age = 0
        self._under_way = False

    def act(self, known: SemanticMap, planner: Planner, track: int, *, blocked: bool = False) -> Action:
        """The next action towards a track; Done as soon as it should succeed.

        Plans again every ``REPLAN_STEPS`` actions, and after a failed move.

        Args:
            known: the map, up to date.
            planner: updated here when a new plan is due.
            track: the thing.
            blocked: whether the last move failed.
        """
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
        self.goal = self.approach.goal(known, planner, track) or self.approach.nearer(known, planner, track)
        self._plan = deque(planner.plan(self.goal))
        return self._plan.popleft() if self._plan else Action.ROTATE_LEFT
