"""Fits the figures of the language model that is built in: what it answers, and what it says about places."""
