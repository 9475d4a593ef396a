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
from ucon.perception.tracking.association_kernels import overlaps


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
        track = found.track[found.track >= reserved]
        if not len(track):
            return
        row = np.full(int(track.max()) + 2, -1, np.int32)
        row[track] = np.arange(len(track))
        pixels = np.zeros((len(track), len(frame.counts) + 1), np.int32)
        overlaps(found.image, frame.instance, row, pixels)
        most = pixels.argmax(1)
        for k, thing in enumerate(most.tolist()):
            total = int(pixels[k].sum())
            if total:
                own = thing > 0 and 2 * pixels[k, thing] > total
                self._behind[int(track[k])] = (thing - 1, int(pixels[k, thing])) if own else (-1, 0)

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
            # A track that covers little of it is a small thing in front of it, in a box that is too large.
            found += [track for track, pixels in sizes.items() if 4 * pixels >= max(sizes.values())]
        return tuple(sorted(found))
