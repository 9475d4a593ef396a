"""State of a learner that is decided by its parameters, their optimiser and the number of its steps."""

from __future__ import annotations

from ucon.learning.run.protocol import State
from ucon.learning.run.updates import Updates


class CountedSteps:
    """Base of learners whose next step depends on nothing but ``updates`` and how many steps were taken."""

    updates: Updates
    _done = 0

    def state_dict(self) -> State:
        """Parameters, their moving average, optimiser moments, and the number of steps."""
        return State(self.updates.tensors(), {"done": self._done})

    def load_state_dict(self, state: State) -> None:
        """Restore a state of :meth:`state_dict`; the next step is number ``done``.

        Raises:
            DataError: a state of another network or learner.
        """
        self._done = state.count("done")
        self.updates.load(state.tensors, self._done)
