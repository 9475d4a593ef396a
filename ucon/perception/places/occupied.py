"""Whether something stands where a thing was seen before, by depth alone, whatever the detector finds or misses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.model import RELATIONS, Spot
from ucon.perception.mapping.semantic_map import SemanticMap, camera_of
from ucon.perception.places.affordances import affordance
from ucon.perception.places.occupied_kernels import fill
from ucon.perception.places.place_kernels import INSIDE

#: A place is the box in which a thing was seen, without what it stood on: it begins this far above the bottom of the
#: box, metres, but at most this share of the box's height.
ABOVE_M, MOST_ABOVE = 0.015, 0.4
#: Fewest sight lines by which a place is judged; something stands there if at least SHARE of them end in it, and
#: nothing if less than EMPTY_SHARE do.
LEAST_LINES, SHARE, EMPTY_SHARE = 4, 0.3, 0.1
#: A place is at a container that is no farther away than this, metres.
AT_M: Final = 0.2
#: How much more probable it is to see something, and to see nothing, at the place of a thing if the thing is there than
#: if it is elsewhere. From 186 remembered places in 82 requests of ``lives_val``.
STANDS: Final = 5.0
IS_EMPTY: Final = 0.3


def boxes_above(xyz: NDArray[np.float64], size: NDArray[np.float64]) -> NDArray[np.float64]:
    """The boxes (n, 6) of places without what the things stood on, metres.

    Args:
        xyz: (n, 3) middles of what was seen, metres.
        size: (n, 3) sides of what was seen, metres.
    """
    boxes = np.concatenate([xyz - 0.5 * size, xyz + 0.5 * size], axis=1)
    boxes[:, 2] += np.minimum(ABOVE_M, MOST_ABOVE * size[:, 2])
    return boxes


def _is_shut_in(at: tuple[str, str]) -> bool:
    """Whether a place, given as relation and anchor, is inside a container that opens."""
    relation, anchor = at
    return relation == RELATIONS[INSIDE] and affordance(anchor).openable


class Occupied(PartlyShared):
    """Which places are occupied, in one request; for each place, the frame that shows it largest counts."""

    _shared: ClassVar[frozenset[str]] = frozenset({"boxes", "_known"})
    _flat: ClassVar[frozenset[str]] = frozenset({"filled", "now", "open", "_lines"})

    def __init__(self, xyz: NDArray[np.float64], size: NDArray[np.float64], spots: Sequence[Spot]) -> None:
        """Start without a frame.

        Args:
            xyz: (n, 3) middles of what was seen, metres.
            size: (n, 3) sides of what was seen, metres; 0 where they are not known: such places are not checked.
            spots: relations and anchors of the n places; those in containers are checked once these are open.
        """
        #: (n, 6) boxes that are checked, metres
        self.boxes = boxes_above(xyz, size)
        self._known = size.min(1, initial=np.inf) > 0.0
        #: (n,) places that are in no container, or in one that is open
        self.open = ~np.array([any(map(_is_shut_in, spot)) for spot in spots], bool)
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
        self.open |= self._by_open(known)
        lines = np.where(self._known & self.open, filled + passed, 0)
        better = (lines >= LEAST_LINES) & (lines >= self._lines)
        self._lines[better], self.now = lines[better], np.minimum(filled, lines)
        self.filled[better] = filled[better] / lines[better]

    def _by_open(self, known: SemanticMap) -> NDArray[np.bool_]:
        """(n,) places at containers that are open."""
        opened = np.flatnonzero(known.opened[: known.n_tracks])
        if not len(opened):
            return np.zeros(len(self.boxes), bool)
        box, of = self.boxes[:, None], known.box[opened][None]
        apart = np.maximum(np.maximum(of[..., :3] - box[..., 3:], box[..., :3] - of[..., 3:]), 0.0)
        return np.asarray((np.linalg.norm(apart, axis=2) <= AT_M).any(1))

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
