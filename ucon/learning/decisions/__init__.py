"""Decisions of searches in training homes, with labels: searched once, kept in the cache, learned from often."""
