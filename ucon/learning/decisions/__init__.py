"""Labelled decisions of searches in training homes: played once, kept in the cache, and learned from many times."""
