"""``learner=ppo``: learning from what came of it, by TorchRL's collectors, advantages and loss."""
