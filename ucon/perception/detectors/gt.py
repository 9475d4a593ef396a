"""The ``gt`` detector: what is in view, under numbers that tell nothing about the simulator.

A track is an instance under a number given in order of first sight, so that the simulator's own numbering (in
which the episode's objects come last) never reaches an agent.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.sharing import PartlyShared
from ucon.perception.detectors.base import Frame
from ucon.perception.mapping.detections import MIN_PIXELS, Detections


class GtDetector(PartlyShared):
    """Reports every instance with at least ``min_pixels`` pixels in the canonical 128 x 128 view, and no other."""

    _shared: ClassVar[frozenset[str]] = frozenset({"_categories"})

    name = "gt"
    needs_rgb = False

    def __init__(self, min_pixels: int = MIN_PIXELS) -> None:
        if min_pixels < 1:
            raise ConfigError(f"detector.min_pixels={min_pixels}: expected 1 or more")
        self._min_pixels = min_pixels
        self.reset("", ())

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode with instances of these categories."""
        self._categories = categories
        #: track of every instance, the last entry for "no instance" (-1 in an instance image)
        self._track: NDArray[np.int16] = np.full(len(categories) + 1, -1, np.int16)
        #: how many instances have a track
        self._known = 0

    def detect(self, frame: Frame) -> Detections:
        """Instances that count as seen; new ones are numbered by size."""
        counts = frame.counts
        seen = np.flatnonzero(counts >= self._min_pixels)
        new = seen[self._track[seen] < 0]
        if len(new):
            for instance in new[np.lexsort((new, -counts[new]))]:
                self._track[instance] = self._known
                self._known += 1
        seen = seen[np.argsort(self._track[seen])]
        names = tuple(self._categories[k] for k in seen.tolist())
        image = self._track.take(frame.instance, mode="wrap")  # -1 is the last entry
        return Detections(self._track[seen], names, counts[seen], image)

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks of instances; unseen ones are left out."""
        return tuple(int(self._track[k]) for k in instances if self._track[k] >= 0)

    def close(self) -> None:
        """Nothing to release."""
