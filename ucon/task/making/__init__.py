"""Making episodes: households of homes, placements, a user's own household, whole sets."""
