"""A training run: its folder, checkpoints, plan and progress, and the interface of learners."""
