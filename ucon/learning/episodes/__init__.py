"""``learner=ppo_episodes``: PPO on whole episodes, played many at once."""
