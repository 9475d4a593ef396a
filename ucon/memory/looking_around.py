"""Looking around before a request ends: this needs no moves, and what the robot sees may be asked for next."""

from __future__ import annotations

from ucon.memory.protocol import Info
from ucon.perception.mapping.body import Body
from ucon.task.actions import Action
from ucon.task.rules import PAPER, task_rules


class LookingAround:
    """Makes one full turn when the agent would call Done, then calls it."""

    def __init__(self) -> None:
        """Start without a request."""
        self._turns, self._turned, self._headings, self._most = 0, False, 0, 0

    def begin(self, info: Info) -> None:
        """Begin a request.

        Args:
            info: info of its first frame.
        """
        self._turns, self._turned = 0, False
        self._headings = Body.of(info).headings
        self._most = task_rules(str(info.get("task", PAPER.name))).max_steps

    def act(self, action: int, step: int) -> int:
        """The action to carry out.

        Args:
            action: the agent's action.
            step: number of the frame in the request, from 0.
        """
        if action == Action.DONE and not self._turned and step + self._headings < self._most:
            self._turns, self._turned = self._headings, True
        if self._turns > 0:
            self._turns -= 1
            return Action.ROTATE_LEFT
        return Action.DONE if self._turned else action
