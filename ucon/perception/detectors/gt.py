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
    """Reports exactly the instances with at least ``min_pixels`` pixels in the canonical 128 x 128 view, and in range.

    Implements :class:`ucon.perception.detectors.base.Detector`.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_categories"})

    name = "gt"
    needs_rgb = False

    def __init__(self, min_pixels: int = MIN_PIXELS, range_m: float | None = None) -> None:
        """Set the limits.

        Args:
            min_pixels: least pixels of an instance in the canonical 128 x 128 view.
            range_m: instances whose nearest pixel is farther away than this many metres are not reported; None: no
                limit.

        Raises:
            ConfigError: ``min_pixels`` is below 1, or ``range_m`` not above 0.
        """
        if min_pixels < 1:
            raise ConfigError(f"detector.min_pixels={min_pixels}: expected 1 or more")
        if range_m is not None and not range_m > 0.0:
            raise ConfigError(f"detector.range_m={range_m}: expected metres above 0, or null for no limit")
        self._min_pixels, self._range_m = min_pixels, range_m
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
        shown, tracks = counts >= self._min_pixels, self._track
        if self._range_m is not None:
            far = self._far(frame, self._range_m)
            shown = shown & ~far[:-1]
        seen = np.flatnonzero(shown)
        new = seen[self._track[seen] < 0]
        if len(new):
            for instance in new[np.lexsort((new, -counts[new]))]:
                self._track[instance] = self._known
                self._known += 1
        seen = seen[np.argsort(self._track[seen])]
        names = tuple(self._categories[k] for k in seen.tolist())
        if self._range_m is not None:
            tracks = np.where(far, -1, tracks)
        image = tracks.take(frame.instance, mode="wrap")  # -1 is the last entry
        return Detections(self._track[seen], names, counts[seen], image)

    def _far(self, frame: Frame, range_m: float) -> NDArray[np.bool_]:
        """(n + 1,) whether each instance is out of range; the last entry stands for pixels of no instance."""
        nearest = np.full(len(self._track), np.inf, np.float32)
        shown = frame.depth > 0.0
        np.minimum.at(nearest, frame.instance[shown], frame.depth[shown])
        return nearest > range_m

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks of instances; instances never seen are left out."""
        return tuple(int(self._track[k]) for k in instances if self._track[k] >= 0)

    def close(self) -> None:
        """Nothing to release."""
