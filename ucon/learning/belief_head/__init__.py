"""``learner=belief``: where things are kept, from the habits of many households."""
