"""Which track stands for which instance: the environment's bookkeeping for what an Open opened.

Only the simulator knows what was opened. A detector's track stands for it if most of the track's pixels, in the last
frame that showed it, lay on that instance.
"""

from __future__ import annotations

import numpy as np

from ucon.perception.detections import Detections
from ucon.perception.detectors.base import Frame


class Owners:
    """The instance behind every track, as far as there is one (privileged)."""

    def __init__(self) -> None:
        self._instance: dict[int, int] = {}

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
        self._instance.update(dict.fromkeys(np.unique(track).tolist(), -1))
        most = (2 * pixels > total[track]) & (instance > 0)
        self._instance.update(zip(track[most].tolist(), (instance[most] - 1).tolist(), strict=True))

    def of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks that stand for any of ``instances``, ascending."""
        wanted = set(instances)
        return tuple(track for track, instance in sorted(self._instance.items()) if instance in wanted)
