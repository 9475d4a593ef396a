"""Verifiers of generated entries, measured on the same labelled pairs of a sentence and a placement."""
