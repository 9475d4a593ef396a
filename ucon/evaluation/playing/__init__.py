"""Playing episodes: one agent in one process, worker processes, pictures and progress."""
