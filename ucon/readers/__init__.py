"""Readers of habits: they turn the sentences that an agent is given into a distribution over the target's places."""

from ucon.readers.anchor_reader import AnchorBelief, AnchorReader, Reading

__all__ = ["AnchorBelief", "AnchorReader", "Reading"]
