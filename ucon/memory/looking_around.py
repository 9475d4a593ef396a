"""Looking around before a request ends: what the robot sees then costs no way, and may be asked for next."""

from __future__ import annotations

from ucon.memory.protocol import Info
from ucon.perception.mapping.body import Body
from ucon.task.actions import Action
from ucon.task.rules import PAPER, task_rules


class LookingAround:
    """Turns once where the agent would call Done, then calls it."""

    def __init__(self) -> None:
        """Start without a request."""
        self._turns, self._turned, self._headings, self._most = 0, False, 0, 0

    def begin(self, info: Info) -> None:
        """Begin a request.

        Args:
            info: of its first frame.
        """
        self._turns, self._turned = 0, False
        self._headings = Body.of(info).headings
        self._most = task_rules(str(info.get("task", PAPER.name))).max_steps

    def act(self, action: int, step: int) -> int:
        """The action that is carried out.

        Args:
            action: the agent's.
            step: number of the frame in the request, from 0.
        """
        if action == Action.DONE and not self._turned and step + self._headings < self._most:
            self._turns, self._turned = self._headings, True
        if self._turns > 0:
            self._turns -= 1
            return Action.ROTATE_LEFT
        return Action.DONE if self._turned else action
