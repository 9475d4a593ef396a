"""The errors of detectors, and what follows from them: what a thing is, and whether it is there at all."""
