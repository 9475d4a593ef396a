"""Training: learners, checkpoints, and runs that can be interrupted anywhere.

A learner is known by its protocol (:class:`~ucon.learning.run.protocol.Learner`): one update at a time, its state as
named tensors and plain values. Everything else (the run folder, resuming, signals, the model card) is the same for all.
"""

from ucon.learning.run.protocol import Learner, State

__all__ = ["Learner", "State"]
