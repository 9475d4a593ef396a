"""The floor for a robot that moves continuously: an upright cylinder among the collision solids."""
