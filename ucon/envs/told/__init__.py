"""Changes to the habits that an agent is given: false sentences among them, or sentences left out or replaced."""
