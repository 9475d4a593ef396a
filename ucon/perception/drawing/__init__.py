"""Pictures of what an agent knows and intends."""
