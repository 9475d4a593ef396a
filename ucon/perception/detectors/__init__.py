"""Detectors turn frames into tracked things. Each has its own file; all share one vocabulary and one output format."""

from ucon.perception.detectors.base import Detector, Frame, vocabulary
from ucon.perception.detectors.gt import GtDetector

__all__ = ["Detector", "Frame", "GtDetector", "vocabulary"]
