"""Foresight: learning from labelled decisions by how much each view shortens the way to the target."""
