"""Foresight: learning what lies beyond each view from labelled decisions."""
