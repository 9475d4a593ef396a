"""Search agents: one file, one class."""
