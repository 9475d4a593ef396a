"""``learner=belief``: trains the belief head on the habits of many households."""
