"""The real robot: a rig of sensors on a body that moves continuously, as exactly as its motors and odometry let it."""
