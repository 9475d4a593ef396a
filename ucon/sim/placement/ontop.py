"""On top: slots on the anchor's surfaces, or on the floor of a room."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ucon.sim.house import STRUCTURE
from ucon.sim.placement.common import Request, alternate, depth_penalty, ordered
from ucon.sim.placement.reasons import RefusedError
from ucon.sim.placement.slots import Pose, Slot, centres_in, poses
from ucon.sim.placement.surroundings import FLOOR, SURFACE, Surroundings
from ucon.sim.shapes import Array

OVERHANG = 0.3
"""How much longer than the surface an object may be, as a share."""
_PER_LEVEL = 8
_SAME_HEIGHT_M = 0.005
_JOINT_M = 0.03
_SLAB_M = 0.10
_COVERED_SHARE = 0.7


def candidates(request: Request) -> Iterator[Slot]:
    """Slots on top of the anchor, ordered.

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


def floor_levels(scene: Surroundings, anchor: int) -> list[Array]:
    """The floor of a room as levels (6,)."""
    return [scene.levels.box[row] for row in scene.levels_of(anchor, FLOOR)]


def tops(scene: Surroundings, anchor: int) -> list[Array]:
    """Levels (6,) on top of an instance.

    A slab that covers it (the counter on a cabinet or dishwasher) is its top; a counter goes on in its neighbour.
    """
    levels, result = scene.levels, []
    for row in scene.levels_of(anchor, SURFACE):
        cover = _cover(scene, row)
        if cover is None:
            result.append(_widened(scene, row))
            continue
        level = levels.box[cover].copy()
        own = scene.boxes[anchor]
        level[:2], level[3:5] = np.maximum(level[:2], own[:2]), np.minimum(level[3:5], own[3:5])
        result.append(level)
    return result


def cover_of(scene: Surroundings, anchor: int) -> set[int]:
    """Instances that cover the tops of an instance like a slab."""
    covers = [_cover(scene, row) for row in scene.levels_of(anchor, SURFACE)]
    return {int(scene.levels.owner[cover]) for cover in covers if cover is not None}


def _cover(scene: Surroundings, row: int) -> int | None:
    """Row of a surface close above another that hides most of it; None for a bare top."""
    levels, own = scene.levels, scene.levels.box[row]
    rise = levels.box[:, 2] - own[2]
    near = (levels.kind == SURFACE) & (levels.owner != levels.owner[row]) & (rise > 0.0) & (rise < _SLAB_M)
    size = (own[3] - own[0]) * (own[4] - own[1])
    for other in np.flatnonzero(near & (levels.owner < scene.house.n_items)):
        box = levels.box[other]
        shared = np.maximum(np.minimum(box[3:5], own[3:5]) - np.maximum(box[:2], own[:2]), 0.0)
        if shared[0] * shared[1] > _COVERED_SHARE * size:
            return int(other)
    return None


def _widened(scene: Surroundings, row: int) -> Array:
    """A surface with the halves of neighbours at the same height that continue it: one counter, several pieces."""
    level = scene.levels.box[row].copy()
    own = scene.levels.box[row]
    for other in np.flatnonzero(scene.levels.kind == SURFACE):
        box = scene.levels.box[other]
        if other == row or abs(box[2] - own[2]) > _SAME_HEIGHT_M:
            continue
        for axis in (0, 1):
            along = 1 - axis
            if box[along] > own[along] + _JOINT_M or box[3 + along] < own[3 + along] - _JOINT_M:
                continue
            half = (box[3 + axis] - box[axis]) / 2
            if abs(box[axis] - own[3 + axis]) < _JOINT_M:
                level[3 + axis] = own[3 + axis] + half
            if abs(box[3 + axis] - own[axis]) < _JOINT_M:
                level[axis] = own[axis] - half
    return level


def _fitting(request: Request, level: Array) -> list[Pose]:
    lay = request.row.mount != "floor"
    return [
        pose
        for pose in poses(request.shape, lay=lay)
        if pose.extent[2] <= level[5] - level[2] + 1e-6
        and (pose.extent[:2] <= (level[3:5] - level[:2]) * (1 + OVERHANG)).all()
    ]


def _slots(request: Request, fitting: list[tuple[Array, Pose]], on_floor: bool) -> Iterator[Slot]:
    """Poses in their order of preference (pairs of quarter turns), levels mixed within each."""
    stages: dict[float, list[tuple[Array, Pose]]] = {}
    for level, pose in fitting:
        stages.setdefault(round(float(pose.extent[2]), 6), []).append((level, pose))
    for stage in stages.values():
        shuffled = [stage[k] for k in request.rng.permutation(len(stage))]
        yield from alternate([_on_level(request, level, pose, on_floor) for level, pose in shuffled])


def _on_level(request: Request, level: Array, pose: Pose, on_floor: bool) -> Iterator[Slot]:
    centres = centres_in(level[[0, 1, 3, 4]], pose.extent, OVERHANG)
    penalty: Array | float = depth_penalty(request, centres, level[2])
    if on_floor and len(centres):
        # Along the walls, as people do: the middle of the floor is walked on.
        edge = np.minimum(centres - level[:2], level[3:5] - centres).min(axis=1)
        penalty = 2.0 * edge
    return ordered(request, centres, level[2], pose, penalty, keep=_PER_LEVEL)
