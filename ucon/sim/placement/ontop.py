"""``ontop``: slots on the anchor's surfaces, or on the floor of a room."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ucon.sim.house import STRUCTURE
from ucon.sim.placement.common import PlacementRequest, alternate, depth_penalty, ordered
from ucon.sim.placement.reasons import RefusedError
from ucon.sim.placement.slots import Slot, SlotPose, centres_in, poses
from ucon.sim.placement.tops import floor_levels, tops
from ucon.sim.shapes import Array

OVERHANG = 0.3
"""How much longer than the surface an object may be, as a fraction."""
_PER_LEVEL = 8


def candidates(request: PlacementRequest) -> Iterator[Slot]:
    """Slots on top of the anchor, the best first.

    Raises:
        RefusedError: it is no support, or the object is too large for all of its surfaces.
    """
    scene = request.scene
    on_floor = request.anchor_name in STRUCTURE
    if on_floor and request.anchor_name != "floors":
        raise RefusedError("implausible", f"nothing stands on {request.anchor_name}")
    levels = floor_levels(scene, request.anchor) if on_floor else tops(scene, request.anchor)
    if not levels:
        raise RefusedError("not_a_support", f"{request.anchor_name} has no level surface on top")
    fitting = [(level, pose) for level in levels for pose in _fitting(request, level)]
    if not fitting:
        raise RefusedError("too_large", f"{request.category} is larger than the top of {request.anchor_name}")
    return _slots(request, fitting, on_floor)


def _fitting(request: PlacementRequest, level: Array) -> list[SlotPose]:
    return [pose for pose in poses(request.shape, lay=False) if fits(level, pose)]


def fits(level: Array, pose: SlotPose) -> bool:
    """Whether an object in a pose fits on an empty level, with a little overhang.

    Args:
        level: (6,) x0, y0, height, x1, y1, height of what is above it; metres.
        pose: orientation of the object.
    """
    room = level[3:5] - level[:2]
    return bool(pose.extent[2] <= level[5] - level[2] + 1e-6 and (pose.extent[:2] <= room * (1 + OVERHANG)).all())


def _slots(request: PlacementRequest, fitting: list[tuple[Array, SlotPose]], on_floor: bool) -> Iterator[Slot]:
    """Poses in their order of preference (pairs of quarter turns), levels mixed within each."""
    stages: dict[float, list[tuple[Array, SlotPose]]] = {}
    for level, pose in fitting:
        stages.setdefault(round(float(pose.extent[2]), 6), []).append((level, pose))
    for stage in stages.values():
        shuffled = [stage[k] for k in request.rng.permutation(len(stage))]
        yield from alternate([_on_level(request, level, pose, on_floor) for level, pose in shuffled])


def _on_level(request: PlacementRequest, level: Array, pose: SlotPose, on_floor: bool) -> Iterator[Slot]:
    centres = centres_in(level[[0, 1, 3, 4]], pose.extent, OVERHANG)
    penalty: Array | float = depth_penalty(request, centres, level[2])
    if on_floor and len(centres):
        # Along the walls: the middle of the floor is walked on.
        edge = np.minimum(centres - level[:2], level[3:5] - centres).min(axis=1)
        penalty = 2.0 * edge
    return ordered(request, centres, level[2], pose, penalty, keep=_PER_LEVEL)
