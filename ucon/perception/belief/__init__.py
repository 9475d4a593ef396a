"""Where the target may be, given the habits and what was seen."""
