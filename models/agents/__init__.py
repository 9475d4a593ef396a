"""Search agents, one class per file."""
