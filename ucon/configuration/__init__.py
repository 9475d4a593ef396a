"""What configurations may contain: kinds of values, permitted constructors, names of older versions; and help pages."""
