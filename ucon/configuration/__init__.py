"""What configurations may say: kinds of values, permitted constructors, names of older versions, help."""
