"""What all detectors share that find labelled boxes: one looks for boxes, the tracker follows them."""

from __future__ import annotations

from abc import ABC, abstractmethod

from ucon.core.sharing import PartlyShared
from ucon.perception.detectors.base import Frame
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.detectors.owners import Owners
from ucon.perception.detectors.tracker import GATE_M, STRUCTURE, Tracker
from ucon.perception.mapping.detections import Detections


class BoxDetector(PartlyShared, ABC):
    """A detector by :meth:`find`. ``gate_m`` is the tracker's."""

    name = ""
    needs_rgb = True

    def __init__(self, gate_m: float = GATE_M) -> None:
        self._tracker = Tracker(gate_m)
        self._owners = Owners()

    @abstractmethod
    def find(self, frame: Frame) -> Boxes:
        """Boxes in one frame."""

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode."""
        self._tracker.reset()
        self._owners = Owners()

    def detect(self, frame: Frame) -> Detections:
        """Boxes of the next frame, followed."""
        found = self._tracker.follow(self.find(frame), frame)
        self._owners.note(found, frame, len(STRUCTURE))
        return found

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks most of whose pixels lay on one of the instances when they were last seen."""
        return self._owners.of(instances)

    def close(self) -> None:
        """Release what the detector holds."""
