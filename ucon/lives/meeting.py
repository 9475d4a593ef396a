"""Whether two things at their places would touch, judged by the boxes around their parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.sim.arrangement import PlacedObject
from ucon.sim.shapes import object_solid, object_turn, primitive_boxes

Boxes = NDArray[np.float64]


def object_boxes(placed: PlacedObject) -> Boxes:
    """Boxes (n, 6) around the parts of an object, world metres."""
    return np.asarray(primitive_boxes(object_solid(placed), placed.position, object_turn(placed)))


def meet(a: Boxes, b: Boxes, gap_m: float = 0.0) -> bool:
    """Whether a box of one list is closer than a gap to a box of the other.

    Args:
        a: (n, 6) metres.
        b: (m, 6) metres.
        gap_m: the gap.
    """
    deep = np.minimum(a[:, None, 3:], b[None, :, 3:]) - np.maximum(a[:, None, :3], b[None, :, :3])
    return bool((deep > -gap_m).all(2).any())
