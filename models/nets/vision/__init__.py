"""Encoders of images and of what detectors see."""
