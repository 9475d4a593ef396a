"""Readers of habits: what the sentences that an agent is given say about where its target is kept."""

from ucon.readers.anchor_reader import AnchorBelief, AnchorReader, Reading

__all__ = ["AnchorBelief", "AnchorReader", "Reading"]
