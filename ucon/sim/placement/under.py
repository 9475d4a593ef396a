"""``under``: slots on the floor below the anchor, the most visible first; for wall items, on what is below them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ucon.sim.house import STRUCTURE
from ucon.sim.placement.common import PlacementRequest, depth_penalty, ordered
from ucon.sim.placement.nextto import below_hanging, is_hanging, under_rect, under_spaces
from ucon.sim.placement.reasons import RefusedError
from ucon.sim.placement.slots import Slot, SlotPose, centres_in, poses
from ucon.sim.shapes import Array

LOW_M = 0.35
_SPILL = 0.5
"""Fraction of the footprint that must fit below the anchor; the centre is always below it."""


def candidates(request: PlacementRequest) -> Iterator[Slot]:
    """Slots under the anchor, the best first.

    Raises:
        RefusedError: there is no space under it, or the object is too tall for it.
    """
    scene, box = request.scene, request.anchor_box
    if request.anchor_name in STRUCTURE:
        raise RefusedError("implausible", f"nothing is under {request.anchor_name}")
    spaces = under_spaces(scene, request.anchor)
    if is_hanging(scene, request.anchor):
        return below_hanging(request, under_rect(spaces, box), ceiling_m=float(box[2]))
    if not spaces:
        raise RefusedError("no_room_under", f"there is no space under {request.anchor_name}")
    fitting = [(s, pose) for s in spaces for pose in poses(request.shape, lay=True) if fits(s, pose)]
    if not fitting:
        raise RefusedError("too_large", f"{request.category} is too large for the space under {request.anchor_name}")
    return _slots(request, fitting)


def fits(space: Array, pose: SlotPose) -> bool:
    """Whether an object in a pose fits into a space under something, sticking out a little.

    Args:
        space: (6,) metres.
        pose: orientation of the object.
    """
    room = space[3:] - space[:3]
    return bool(pose.extent[2] <= room[2] - 0.004 and (pose.extent[:2] * _SPILL <= room[:2]).all())


def _slots(request: PlacementRequest, fitting: list[tuple[Array, SlotPose]]) -> Iterator[Slot]:
    for first in (True, False):
        for space, pose in fitting:
            # Under low things only the rim can be seen, so objects there stick out a little.
            inner = first != (space[5] - space[2] < LOW_M)
            rect = space[[0, 1, 3, 4]]
            if not inner:
                spill = pose.extent[:2] * _SPILL
                rect = rect + np.array([-spill[0], -spill[1], spill[0], spill[1]])
            centres = centres_in(rect, pose.extent)
            penalty = (3.0 if inner else 12.0) * np.asarray(depth_penalty(request, centres, space[2]))
            yield from ordered(request, centres, space[2], pose, penalty, keep=8)
