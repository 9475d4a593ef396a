"""``learner=ppo``: training policies on their own play, with TorchRL's collectors, advantages and loss."""
