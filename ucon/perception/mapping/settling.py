"""The furniture of a home that is lived in, from single looks of many searches, where the detector errs.

A box that holds every point ever taken for a thing only grows: one look that includes part of a neighbour enlarges it
for good. And a thing that is called by two names, or seen in parts, is followed as two. Over one search that matters
little; over weeks tables reach into their neighbours, every cabinet is on the map three times, and what stands on one
seems to stand in another. So boxes become those on which most looks agree, and between searches tracks of one thing are
united, and tracks that were looked for in vain more often than found are forgotten.
"""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.perception.detectors.base import vocabulary
from ucon.perception.errors.model import DetectorErrors
from ucon.perception.hypotheses.hypotheses import limits_m2
from ucon.perception.hypotheses.look_kernels import MOST_OCTAVES
from ucon.perception.mapping import settling_kernels as kernels
from ucon.perception.mapping.detections import Detections

#: A track is forgotten if the log probability of all its looks in vain, times this weight, outweighs the number of
#: times that it was found.
IN_VAIN = 0.5


class LookBoxes(PartlyShared):
    """One box of each track for each side and distance: looks from one side and distance err together."""

    _flat: ClassVar[frozenset[str]] = frozenset({"_most", "_names", "_boxes"})

    def __init__(self, errors: DetectorErrors) -> None:
        """Start without looks.

        Args:
            errors: of the detector; they say which looks err together.
        """
        self._sides, self._limits_m2 = errors.sides, limits_m2(errors.octave)
        keys = errors.sides * MOST_OCTAVES
        self._most, self._names = np.zeros((0, keys), np.int32), np.zeros((0, keys), np.int16)
        self._boxes = np.zeros((0, keys, 6), np.float32)

    def look(
        self,
        depth: NDArray[np.float32],
        image: NDArray[np.int16],
        camera: NDArray[np.float64],
        called: NDArray[np.int32],
        opened: NDArray[np.bool_],
    ) -> None:
        """Take in a frame.

        Args:
            depth: (H, W), metres.
            image: (H, W), track of every pixel, -1 for none.
            camera: (8,) float64.
            called: (T,) row in the vocabulary of the name that the detector gives each track in this frame; -1: none.
            opened: (T,) tracks whose doors swing.
        """
        n = len(called)
        self._reserve(n)
        extent, pixels = np.empty((n, 6)), np.empty(n, np.int32)
        kernels.extents(depth, image, camera, extent, pixels)
        kernels.note(
            extent, pixels, called, opened, camera, self._sides, self._limits_m2,
            self._most[:n], self._names[:n], self._boxes[:n],
        )  # fmt: skip

    def settle(self, names: NDArray[np.int32], box: NDArray[np.float64]) -> None:
        """Set the boxes of tracks to those on which their looks agree.

        Args:
            names: (T,) row in the vocabulary of each track's name; -1 for those whose box stays.
            box: (T, 6) metres, updated.
        """
        n = min(len(names), len(self._most))
        settled, is_set = np.empty((n, 6)), np.empty(n, np.uint8)
        wide_m, high_m = _sizes_m()[:, names[:n]]
        kernels.settle(self._most[:n], self._names[:n], self._boxes[:n], names[:n], wide_m, high_m, settled, is_set)
        rows = np.flatnonzero(is_set)
        box[rows] = settled[rows]

    def forget(self, tracks: list[int]) -> None:
        """Drop the looks at some tracks."""
        self._most[[track for track in tracks if track < len(self._most)]] = 0

    def _reserve(self, n: int) -> None:
        """Make room for n tracks."""
        if (old := len(self._most)) < n:
            for name in ("_most", "_names", "_boxes"):
                column = getattr(self, name)
                blank = np.zeros((2 * n - old, *column.shape[1:]), column.dtype)
                setattr(self, name, np.concatenate([column, blank]))


class United:
    """Which of the detector's tracks are one thing.

    Attributes:
        into: (n,) track that stands for each; tracks beyond these stand for themselves.
    """

    def __init__(self) -> None:
        """Start with every track standing for itself."""
        self.into = np.zeros(0, np.int32)

    def unite(self, box: NDArray[np.float64], names: NDArray[np.int32], looks: NDArray[np.float64]) -> list[int]:
        """Unite tracks of one thing.

        Args:
            box: (T, 6) metres.
            names: (T,) row in the vocabulary of each track's name; -1 for those that are left alone.
            looks: (T,) how often each was found.

        Returns:
            Tracks for which another one stands from now on.
        """
        into = np.empty(len(names), np.int32)
        kernels.unite(box, names, looks, into)
        self.into = into[np.append(self.into, np.arange(len(self.into), len(into), dtype=np.int32))]
        return np.flatnonzero(into != np.arange(len(into))).tolist()

    def of(self, track: int) -> int:
        """The track that stands for one."""
        return int(self.into[track]) if track < len(self.into) else track

    def detections(self, found: Detections) -> Detections:
        """A frame's detections with one track for each thing.

        Of several tracks of a thing, the row of the one with most pixels stays; in the image they all become one.

        Args:
            found: the frame's detections with the detector's own tracks.
        """
        if not len(self.into):
            return found
        last = max(int(found.track.max(initial=-1)), int(found.image.max(initial=-1)), len(self.into) - 1)
        into = np.arange(-1, last + 1, dtype=np.int32)  # row 0 is for pixels of no track
        into[1 : len(self.into) + 1] = self.into
        track = into[found.track + 1]
        order = np.lexsort((-found.pixels, track))
        rows = order[np.diff(track[order], prepend=-1) > 0]
        names, score = [found.category[row] for row in rows.tolist()], found.score
        image = into[found.image.astype(np.int32) + 1].astype(np.int16)
        return Detections(track[rows], names, found.pixels[rows], image, None if score is None else score[rows])


@lru_cache(maxsize=1)
def _sizes_m() -> NDArray[np.float64]:
    """(2, V) diagonal of the footprint and height of things of every name of the vocabulary, metres."""
    size = np.array([catalogue()[name].size for name in vocabulary()])
    return np.stack([np.hypot(size[:, 0], size[:, 1]), size[:, 2]])
