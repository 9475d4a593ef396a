"""The belief head: a trained network that reads habits, in place of the fitted reader."""
