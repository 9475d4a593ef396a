"""The ``gt`` detector's output: what is in view, under numbers that tell nothing about the simulator.

A track is an instance under a number given in order of first sight, so that the simulator's own numbering (in
which the episode's objects come last) never reaches an agent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Detections:
    """What is seen in one frame: parallel arrays by track; tracks count up by size among the newly seen."""

    track: NDArray[np.int16]
    pixels: NDArray[np.int32]
    category: tuple[str, ...]


class Tracks:
    """Numbers instances in order of first sight within one episode."""

    def __init__(self, categories: tuple[str, ...], min_pixels: int = 4) -> None:
        self._categories = categories
        self._min_pixels = min_pixels
        #: track of every instance, the last entry for "no instance" (-1 in an instance image)
        self._track = np.full(len(categories) + 1, -1, np.int16)
        self.instance: list[int] = []
        """Instance behind every track (privileged)."""

    def see(self, counts: NDArray[np.int32]) -> Detections:
        """Update with the pixel counts of a frame (n_instances,) and list what is detected in it."""
        seen = np.flatnonzero(counts >= self._min_pixels)
        new = seen[self._track[seen] < 0]
        if len(new):
            for instance in new[np.lexsort((new, -counts[new]))]:
                self._track[instance] = len(self.instance)
                self.instance.append(int(instance))
        seen = seen[np.argsort(self._track[seen])]
        return Detections(self._track[seen], counts[seen], tuple(self._categories[k] for k in seen))

    def image(self, instances: NDArray[np.int16]) -> NDArray[np.int16]:
        """Track of every pixel of an instance image (H, W); -1 where nothing is detected."""
        return self._track[instances]

    def of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks of instances; unseen ones are left out."""
        return tuple(int(self._track[k]) for k in instances if self._track[k] >= 0)
