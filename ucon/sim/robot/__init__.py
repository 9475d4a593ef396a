"""The floor as a robot meets it that moves continuously: an upright cylinder against the collision solids."""
