"""Lives: days in one home, in which people use and move their things, and a robot is asked for them."""
