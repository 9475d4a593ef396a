"""Lives: days in one home, in which people use and move their things and ask a robot for them."""
