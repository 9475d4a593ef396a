"""What things on the map may be, where the detector errs: names as probabilities, and whether a thing is there."""
