"""What an agent makes of what it sees: the semantic map, places to look at, views, candidates, the planner."""
