"""Learning to judge suspects."""
