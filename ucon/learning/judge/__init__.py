"""``learner=judge``: trains the judge of suspects."""
