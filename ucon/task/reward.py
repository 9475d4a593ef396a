"""Reward of one step. The paper's release returns 0; this is ours, and every weight is a parameter."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Reward:
    """Weights of a step's reward.

    ``progress`` pays for every metre by which the agent comes closer to the next goal of the stored solution (the
    node where its container is opened, then the node where Done succeeds); it is a difference of potentials.
    """

    success: float = 10.0
    failed_done: float = 0.0
    step: float = -0.01
    collision: float = 0.0
    progress: float = 0.0

    def __call__(self, *, success: bool, done: bool, collision: bool, closer_m: float) -> float:
        """Reward of one step."""
        ending = (self.success if success else self.failed_done) if done else 0.0
        return ending + self.step + self.collision * collision + self.progress * closer_m
