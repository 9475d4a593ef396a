"""Pictures of an agent's map, belief and goal, for videos and reports."""
