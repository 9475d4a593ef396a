"""Encoders of images and of detections."""
