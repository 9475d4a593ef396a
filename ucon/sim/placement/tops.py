"""The levels that count as "on top" of an instance, including slabs that cover it and counters that continue."""

from __future__ import annotations

import numpy as np

from ucon.sim.placement.surroundings import FLOOR_LEVEL, SURFACE, Surroundings
from ucon.sim.shapes import Array

_SAME_HEIGHT_M = 0.005
_JOINT_M = 0.03
_SLAB_M = 0.10
_COVERED_SHARE = 0.7


def floor_levels(scene: Surroundings, anchor: int) -> list[Array]:
    """The floor of a room as levels (6,)."""
    return [scene.levels.box[row] for row in scene.levels_of(anchor, FLOOR_LEVEL)]


def tops(scene: Surroundings, anchor: int) -> list[Array]:
    """Levels (6,) on top of an instance.

    A slab that covers it (the counter on a cabinet or dishwasher) is its top; a counter continues in its neighbour.
    """
    levels, result = scene.levels, []
    for row in scene.levels_of(anchor, SURFACE):
        cover = cover_row(scene, row)
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
    covers = [cover_row(scene, row) for row in scene.levels_of(anchor, SURFACE)]
    return {int(scene.levels.owner[cover]) for cover in covers if cover is not None}


def cover_row(scene: Surroundings, row: int) -> int | None:
    """Row of a surface close above another one that hides most of it; None if nothing covers it."""
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
