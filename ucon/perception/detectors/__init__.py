"""Detectors turn frames into tracked things. One file each; all share one vocabulary and one output."""

from ucon.perception.detectors.base import Detector, Frame, vocabulary
from ucon.perception.detectors.gt import GtDetector

__all__ = ["Detector", "Frame", "GtDetector", "vocabulary"]
