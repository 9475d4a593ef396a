"""Whether something stands where a thing was seen before: depth tells it, whatever the detector finds or misses."""

from __future__ import annotations

from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.semantic_map import SemanticMap, camera_of
from ucon.perception.places.occupied_kernels import fill

#: A place is the box in which a thing was seen, without what it stands on: it begins so much above its bottom, metres,
#: or if the thing is low this share of its height.
ABOVE_M, MOST_ABOVE = 0.015, 0.4
#: Sight lines that tell anything; shares of them that end in a place where something stands, and where nothing does.
LEAST_LINES, SHARE, EMPTY_SHARE = 4, 0.3, 0.1
#: How much more probable it is that something stands at the place of a thing if that is there than if it is elsewhere,
#: and that nothing does. From 186 remembered places in 82 requests of ``lives_val``.
STANDS: Final = 5.0
IS_EMPTY: Final = 0.3


def boxes_above(xyz: NDArray[np.float64], size: NDArray[np.float64]) -> NDArray[np.float64]:
    """The boxes (n, 6) of places without what the things stand on, metres.

    Args:
        xyz: (n, 3) middles of what was seen, metres.
        size: (n, 3) its sides, metres.
    """
    boxes = np.concatenate([xyz - 0.5 * size, xyz + 0.5 * size], axis=1)
    boxes[:, 2] += np.minimum(ABOVE_M, MOST_ABOVE * size[:, 2])
    return boxes


class Occupied(PartlyShared):
    """Follows one request; of each place the frame counts in which it fills most of the picture."""

    _shared: ClassVar[frozenset[str]] = frozenset({"boxes"})
    _flat: ClassVar[frozenset[str]] = frozenset({"filled", "now", "_lines"})

    def __init__(self, xyz: NDArray[np.float64], size: NDArray[np.float64]) -> None:
        """Start without a frame.

        Args:
            xyz: (n, 3) middles of what was seen, metres.
            size: (n, 3) its sides, metres; 0 where they are not known: such places are not asked for.
        """
        #: (n, 6) boxes that are asked for, metres
        self.boxes = boxes_above(xyz, size)
        self._known = size.min(1, initial=np.inf) > 0.0
        #: (n,) share of the sight lines that end there
        self.filled = np.zeros(len(xyz))
        #: (n,) sight lines that end there in the newest frame
        self.now = np.zeros(len(xyz), np.int32)
        self._lines = np.zeros(len(xyz), np.int32)

    def look(self, known: SemanticMap, depth: NDArray[np.float32]) -> None:
        """Take in a frame.

        Args:
            known: the map with the frame.
            depth: (H, W), metres.
        """
        n = len(self.boxes)
        filled, passed = np.zeros(n, np.int32), np.zeros(n, np.int32)
        fill(depth, camera_of(known.view, depth, known.body), self.boxes, filled, passed)
        lines = np.where(self._known, filled + passed, 0)
        better = (lines >= LEAST_LINES) & (lines >= self._lines)
        self._lines[better], self.now = lines[better], filled
        self.filled[better] = filled[better] / lines[better]

    @property
    def asked(self) -> NDArray[np.bool_]:
        """(n,) places that any frame has shown."""
        return self._lines > 0

    @property
    def stands(self) -> NDArray[np.bool_]:
        """(n,) places where something stands."""
        return self.asked & (self.filled >= SHARE)

    def likelihood(self) -> NDArray[np.float64]:
        """(n,) how much more probable what was seen of each place is if its thing is there than if it is elsewhere."""
        empty = self.asked & (self.filled < EMPTY_SHARE)
        return np.where(self.stands, STANDS, np.where(empty, IS_EMPTY, 1.0))
