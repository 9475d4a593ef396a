"""Making episodes: who lives where, what is placed, one's own household, whole sets."""
