"""Slots: ordered positions and orientations at which an object might stand, found with boxes alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import yaw_matrix
from ucon.objects.model import Vec3
from ucon.scenes.spec import GRID_M
from ucon.sim.placement.kernels import are_clear, node_distances
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import Array, Solid, enclosing, primitive_boxes

LIFT_M = 0.001
"""Objects start this high above what they stand on."""
_TOUCH_M = 0.0005
_STEP_M = 0.04
_MAX_PER_AXIS = 24
_NODE_REACH = 5
_SLENDER = 0.14
"""Base over height below which an object is laid down rather than stood up."""

_ROLL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_PITCH = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@dataclass(frozen=True, eq=False)
class SlotPose:
    """An orientation of a solid and the box around it, relative to its origin."""

    turn: Array
    low: Array
    high: Array

    @property
    def extent(self) -> Array:
        """(3,) size of the box."""
        return self.high - self.low


@dataclass(frozen=True, eq=False)
class Slot:
    """Where to try: the origin of the object and its orientation."""

    position: Vec3
    pose: SlotPose

    @property
    def box(self) -> Array:
        """World box (6,)."""
        return np.concatenate([self.pose.low + self.position, self.pose.high + self.position])


def poses(shape: Solid, *, lay: bool, stand: bool = False) -> list[SlotPose]:
    """Orientations to try, best first: upright, then on a side if it is long and thin, or anything if ``lay``.

    What is slender lies first, except where it should ``stand``: a broom on the floor. Each comes in two quarter
    turns; half turns are left to the sampler.
    """
    return list(_poses(_Key(shape), lay, stand))


class _Key:
    """Hash a solid by identity."""

    __slots__ = ("shape",)

    def __init__(self, shape: Solid) -> None:
        self.shape = shape

    def __hash__(self) -> int:
        return id(self.shape)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Key) and other.shape is self.shape


@lru_cache(maxsize=4096)
def _poses(key: _Key, lay: bool, stand: bool) -> tuple[SlotPose, ...]:
    extent = key.shape.extent
    slender = min(extent[0], extent[1]) < _SLENDER * extent[2]
    down = [_PITCH, _ROLL] if extent[0] <= extent[1] else [_ROLL, _PITCH]
    upright = [np.eye(3)]
    order = [*down, *upright] if slender and not stand else upright + (down if lay or is_long(extent) else [])
    return tuple(_pose(key.shape, yaw_matrix(quarter) @ turn) for turn in order for quarter in (0, 1))


def is_long(extent: Array) -> bool:
    """Long and thin: the longest side is at least 2.5 times the next."""
    a, b = sorted(extent.tolist())[1:]
    return b >= 2.5 * a


def _pose(shape: Solid, turn: Array) -> SlotPose:
    box = enclosing(primitive_boxes(shape, (0.0, 0.0, 0.0), turn))
    return SlotPose(turn, box[:3], box[3:])


def flipped(shape: Solid, pose: SlotPose, rng: np.random.Generator) -> SlotPose:
    """The pose or its half turn, at random: both need the same space."""
    return _pose(shape, yaw_matrix(2) @ pose.turn) if rng.random() < 0.5 else pose


def centres_in(rect: Array, extent: Array, overhang: float = 0.0) -> Array:
    """Footprint centres (n, 2) such that a footprint lies in a rectangle (x0, y0, x1, y1).

    Empty where it is larger than the rectangle by more than the factor ``1 + overhang``; a footprint that is
    larger within that factor gets the middle.
    """
    axes = []
    for axis in (0, 1):
        room, need = rect[2 + axis] - rect[axis], extent[axis]
        if need > room * (1.0 + overhang):
            return np.zeros((0, 2))
        low, high = rect[axis] + need / 2, rect[2 + axis] - need / 2
        if high <= low:
            axes.append(np.array([(rect[axis] + rect[2 + axis]) / 2]))
            continue
        count = int(np.clip(np.ceil((high - low) / _STEP_M) + 1, 2, _MAX_PER_AXIS))
        axes.append(np.linspace(low, high, count))
    x, y = np.meshgrid(*axes, indexing="ij")
    return np.stack([x.ravel(), y.ravel()], axis=1)


def slot_boxes(centres: Array, z: float | Array, pose: SlotPose) -> Array:
    """World boxes (n, 6) of an object whose footprint centres are given and that stands at height z."""
    half = pose.extent[:2] / 2
    bottom = np.broadcast_to(np.asarray(z, float), (len(centres),))[:, None] + LIFT_M
    return np.concatenate([centres - half, bottom, centres + half, bottom + pose.extent[2]], axis=1)


def clear(scene: Surroundings, boxes: Array) -> NDArray[np.bool_]:
    """Which boxes (n, 6) meet no part of anything, (n,) bool; slanted parts are left to PyBullet."""
    if not len(boxes):
        return np.zeros(0, bool)
    around = np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])
    rows = scene.parts_near(around)
    return are_clear(scene.parts.boxes[rows[~scene.parts.slanted[rows]]], boxes, _TOUCH_M)


def slots_at(centres: Array, z: float | Array, pose: SlotPose, order: NDArray[np.int64]) -> Iterator[Slot]:
    """Slots in the given order of rows of ``centres``."""
    heights = np.broadcast_to(np.asarray(z, float), (len(centres),))
    offset = (pose.low + pose.high)[:2] / 2
    for k in order:
        x, y = centres[k] - offset
        yield Slot((float(x), float(y), float(heights[k] + LIFT_M - pose.low[2])), pose)


def nearest_node_m(scene: Surroundings, centres: Array, room: int) -> Array:
    """Distance (n,) from points (n, 2) to the nearest free node of a room: what is near can be seen and reached."""
    grid = scene.house.grid
    ox, oy = grid.origin_xy
    free = scene.free & (grid.room == room)
    return node_distances(free, ox, oy, GRID_M, np.ascontiguousarray(centres), _NODE_REACH)
