"""The real robot: a rig of sensors on a body that moves continuously, with errors of motion and odometry."""
