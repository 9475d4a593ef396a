"""The common part of detectors that find labelled boxes: a subclass finds boxes, the tracker follows them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from pathlib import Path

from ucon.core.sharing import PartlyShared
from ucon.perception.detectors.base import Frame
from ucon.perception.detectors.boxes import Boxes
from ucon.perception.errors.model import DetectorErrors, has_errors, read_errors
from ucon.perception.mapping.detections import Detections
from ucon.perception.tracking.owners import TrackInstances
from ucon.perception.tracking.tracker import GATE_M, STRUCTURE, Tracker


class BoxDetector(PartlyShared, ABC):
    """A detector whose subclasses find boxes in single frames (:meth:`find`).

    Implements :class:`ucon.perception.detectors.base.Detector`.
    """

    name = ""
    needs_rgb = True

    def __init__(self, gate_m: float = GATE_M, errors: str | None = None) -> None:
        """Make the tracker.

        Args:
            gate_m: boxes of one category farther apart than this, in metres, are two things.
            errors: file with this detector's errors; None: those that come with the package, where there are any.
        """
        self._errors_file = errors
        self._tracker = Tracker(gate_m)
        self._owners = TrackInstances()

    @cached_property
    def errors(self) -> DetectorErrors | None:
        """The fitted errors of this detector; None where they are not known.

        Raises:
            ConfigError: the file named does not exist, or its errors are those of another detector.
            DataError: the file does not hold the errors of a detector.
        """
        if self._errors_file is not None:
            return read_errors(self.name, Path(self._errors_file))
        return read_errors(self.name) if has_errors(self.name) else None

    @abstractmethod
    def find(self, frame: Frame) -> Boxes:
        """Find labelled boxes in one frame, without regard to earlier frames.

        Returns:
            n boxes in the frame's pixels.
        """

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode: forget all tracks. ``episode`` and ``categories`` are not used here."""
        self._tracker.reset()
        self._owners = TrackInstances()

    def detect(self, frame: Frame) -> Detections:
        """Find boxes in the next frame and assign them to tracks.

        Returns:
            Tracks in view: structure first (floors, walls, ceilings, obstacles), then things.
        """
        return self.follow(self.find(frame), frame)

    def follow(self, boxes: Boxes, frame: Frame) -> Detections:
        """Assign the boxes of the next frame to tracks; see :meth:`detect`.

        Raises:
            DetectorError: scores outside [0, 1], or boxes that are no numbers.
        """
        boxes.check(self.name)
        found = self._tracker.follow(boxes, frame)
        self._owners.note(found, frame, len(STRUCTURE))
        return found

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks that stand for some of the simulator's instances.

        A track stands for an instance if most of its pixels lay on it in the last frame that showed the track.
        """
        return self._owners.of(instances)

    def close(self) -> None:
        """Nothing to release; subclasses with a process end it."""
