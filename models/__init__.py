"""Agents that search homes, and the networks of the learned ones."""
