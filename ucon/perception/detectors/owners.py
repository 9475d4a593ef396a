"""Which track stands for which instance: the environment's bookkeeping for what an Open opened.

Only the simulator knows what was opened. A detector's track stands for it if most of the track's pixels, in the last
frame that showed it, lay on that instance.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ucon.core.sharing import PartlyShared
from ucon.perception.detectors.base import Frame
from ucon.perception.mapping.detections import Detections


class Owners(PartlyShared):
    """The instance behind every track, as far as there is one (privileged)."""

    _flat: ClassVar[frozenset[str]] = frozenset({"_behind"})

    def __init__(self) -> None:
        #: of every track: the instance behind it (-1 none), and how many of its pixels lay on that
        self._behind: dict[int, tuple[int, int]] = {}

    def note(self, found: Detections, frame: Frame, reserved: int) -> None:
        """Take in one frame; tracks below ``reserved`` are structure and stand for nothing."""
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
        """Tracks that stand for any of ``instances``, ascending."""
        found: list[int] = []
        for wanted in set(instances):
            sizes = {track: pixels for track, (instance, pixels) in self._behind.items() if instance == wanted}
            # What covers little of it is a small thing before it, in a box that is too large.
            found += [track for track, pixels in sizes.items() if 4 * pixels >= max(sizes.values())]
        return tuple(sorted(found))
