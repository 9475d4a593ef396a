"""The ``gt`` detector: the simulator's instances in view, renumbered in order of first sight.

The simulator numbers an episode's objects last. Its numbers would give the target away, so they never reach an agent.
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
    """Reports exactly the instances with at least ``min_pixels`` pixels in the canonical 128 x 128 view.

    Implements :class:`ucon.perception.detectors.base.Detector`.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_categories"})

    name = "gt"
    needs_rgb = False

    def __init__(self, min_pixels: int = MIN_PIXELS) -> None:
        """Set the size limit.

        Args:
            min_pixels: least pixels of an instance in the canonical 128 x 128 view.

        Raises:
            ConfigError: ``min_pixels`` is below 1.
        """
        if min_pixels < 1:
            raise ConfigError(f"detector.min_pixels={min_pixels}: expected 1 or more")
        self._min_pixels = min_pixels
        self.reset("", ())

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode: no instance has a track yet.

        Args:
            episode: not used.
            categories: category of every instance.
        """
        self._categories = categories
        #: (n + 1,) track of every instance, -1 without one; the last entry stands for pixels of no instance
        self._track: NDArray[np.int16] = np.full(len(categories) + 1, -1, np.int16)
        #: number of tracks so far
        self._known = 0

    def detect(self, frame: Frame) -> Detections:
        """The instances that count as seen; new ones get the next track numbers, the largest first.

        Returns:
            Tracks, categories, canonical pixel counts, and the track of every pixel. ``score`` is None: never wrong.
        """
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
        """Tracks of instances; instances never seen are left out."""
        return tuple(int(self._track[k]) for k in instances if self._track[k] >= 0)

    def close(self) -> None:
        """Nothing to release."""
