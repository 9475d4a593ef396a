"""The reward of a step. The paper's release returns 0; this one is UcON's own, and every weight is a parameter."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Reward:
    """Weights of a step's reward.

    Attributes:
        success: for a successful Done.
        failed_done: for a failed Done.
        step: for every step.
        collision: for a blocked move.
        progress: for every metre nearer to the goal along the stored solution (via the node where the container is
            opened to the node where Done succeeds); a difference of potentials.
    """

    success: float = 10.0
    failed_done: float = 0.0
    step: float = -0.01
    collision: float = 0.0
    progress: float = 0.0

    def __call__(self, *, success: bool, done: bool, collision: bool, closer_m: float) -> float:
        """The reward of one step.

        Args:
            success: whether Done succeeded.
            done: whether Done was called.
            collision: whether a move was blocked.
            closer_m: metres nearer to the goal than before.
        """
        ending = (self.success if success else self.failed_done) if done else 0.0
        return ending + self.step + self.collision * collision + self.progress * closer_m
