"""Which detector track stands for which simulator instance: the environment's bookkeeping for Open.

Only the simulator knows what an Open opened. A track stands for an instance if most of the track's pixels lay on it, in
the last frame that showed the track.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ucon.core.sharing import PartlyShared
from ucon.perception.detectors.base import Frame
from ucon.perception.mapping.detections import Detections


class TrackInstances(PartlyShared):
    """The simulator instance behind every track. Privileged: no agent may read it."""

    _flat: ClassVar[frozenset[str]] = frozenset({"_behind"})

    def __init__(self) -> None:
        #: by track: its instance (-1: none), and how many of the track's pixels lay on it
        self._behind: dict[int, tuple[int, int]] = {}

    def note(self, found: Detections, frame: Frame, reserved: int) -> None:
        """Update the tracks that one frame shows.

        Args:
            found: the detector's output, with the track of every pixel.
            frame: the frame, with the true instance of every pixel.
            reserved: tracks below this number are structure and stand for no instance.
        """
        own = found.image >= reserved
        if not own.any():
            return
        width = len(frame.counts) + 1
        pairs = found.image[own].astype(np.int64) * width + frame.instance[own] + 1
        pair, pixels = np.unique(pairs, return_counts=True)
        track, instance = np.divmod(pair, width)
        total = np.bincount(track, pixels)
        self._behind.update(dict.fromkeys(track.tolist(), (-1, 0)))
        most = (2 * pixels > total[track]) & (instance > 0)
        for k in np.flatnonzero(most).tolist():
            self._behind[int(track[k])] = (int(instance[k]) - 1, int(pixels[k]))

    def of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks that stand for any of some instances.

        A track that covers less than a quarter of the pixels of the largest one is left out: it is a small thing in
        front, in a box that is too large.

        Returns:
            Track numbers, ascending.
        """
        found: list[int] = []
        for wanted in set(instances):
            sizes = {track: pixels for track, (instance, pixels) in self._behind.items() if instance == wanted}
            # What covers little of it is a small thing before it, in a box that is too large.
            found += [track for track, pixels in sizes.items() if 4 * pixels >= max(sizes.values())]
        return tuple(sorted(found))
