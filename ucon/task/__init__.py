"""The task: an episode, its actions, what is visible, what success is. Knows a habit level by name only."""
