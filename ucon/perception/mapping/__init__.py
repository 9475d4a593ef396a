"""The maps that an agent builds from its own frames, their frontiers, and shortest paths on them."""
