"""The belief head: a network that reads habits, in place of the fitted reader."""
