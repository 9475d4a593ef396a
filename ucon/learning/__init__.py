"""Training: learners, checkpoints, and runs that can be interrupted at any step.

A learner implements one protocol (:class:`~ucon.learning.run.protocol.Learner`): it does one update at a time, and its
state is named tensors and plain values. The run folder, resuming, signals and the model card are shared by all
learners.
"""

from ucon.learning.run.protocol import Learner, State

__all__ = ["Learner", "State"]
