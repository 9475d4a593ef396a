"""The task: episodes, actions, what counts as visible and near, success, rewards and metrics (paper, section III)."""
