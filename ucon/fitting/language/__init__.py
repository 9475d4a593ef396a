"""Fits the embedded language model: its choice among options, and its answers about places."""
