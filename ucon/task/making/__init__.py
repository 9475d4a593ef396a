"""Making episodes: the households of homes, placements, a user's own household, and whole sets."""
