"""A run of training: its folder, checkpoints, plan and progress, and what it asks of a learner."""
