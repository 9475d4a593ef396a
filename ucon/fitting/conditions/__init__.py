"""Fits the condition reader (:mod:`ucon.readers.conditions`): ``python -m ucon data fit-conditions``."""
