"""Slots: positions and orientations at which an object might stand, in order, found with boxes alone."""

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
"""Objects are dropped from this height above what they stand on, metres."""
_TOUCH_M = 0.0005
_STEP_M = 0.04
_MAX_PER_AXIS = 24
_NODE_REACH = 5
_SLENDER = 0.14
"""Objects whose base is narrower than this fraction of their height are laid down first."""

_ROLL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_PITCH = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@dataclass(frozen=True, eq=False)
class SlotPose:
    """An orientation of an object, and the box around it.

    Attributes:
        turn: (3, 3) rotation.
        low: (3,) lower corner of the box relative to the model origin, metres.
        high: (3,) upper corner.
    """

    turn: Array
    low: Array
    high: Array

    @property
    def extent(self) -> Array:
        """(3,) size of the box, metres."""
        return self.high - self.low


@dataclass(frozen=True, eq=False)
class Slot:
    """A place to try: position of the model origin (world metres), and orientation."""

    position: Vec3
    pose: SlotPose

    @property
    def box(self) -> Array:
        """(6,) world box, metres."""
        return np.concatenate([self.pose.low + self.position, self.pose.high + self.position])


def poses(shape: Solid, *, lay: bool, stand: bool = False) -> list[SlotPose]:
    """Orientations to try, the best first: upright, then on a side if the object is long and thin.

    Each comes in two quarter turns; half turns are left to the sampler.

    Args:
        shape: collision primitives of the object.
        lay: allow lying for every object.
        stand: do not lay slender objects down first, such as a broom on the floor.
    """
    return list(_poses(_Key(shape), lay, stand))


class _Key:
    """A solid hashed by identity."""

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
    """Whether the longest side (of extent (3,)) is at least 2.5 times the next."""
    a, b = sorted(extent.tolist())[1:]
    return b >= 2.5 * a


def _pose(shape: Solid, turn: Array) -> SlotPose:
    box = enclosing(primitive_boxes(shape, (0.0, 0.0, 0.0), turn))
    return SlotPose(turn, box[:3], box[3:])


def flipped(shape: Solid, pose: SlotPose, rng: np.random.Generator) -> SlotPose:
    """The pose or its half turn, at random: both need the same space."""
    return half_turned(shape, pose) if rng.random() < 0.5 else pose


def half_turned(shape: Solid, pose: SlotPose) -> SlotPose:
    """The pose turned by half a turn about the vertical."""
    return _pose(shape, yaw_matrix(2) @ pose.turn)


def centres_in(rect: Array, extent: Array, overhang: float = 0.0) -> Array:
    """Footprint centres such that the footprint lies in a rectangle.

    A footprint that is larger than the rectangle, by at most the factor ``1 + overhang``, gets the rectangle's centre.

    Args:
        rect: (4,) x0, y0, x1, y1 in metres.
        extent: (3,) size of the object.
        overhang: see above.

    Returns:
        (n, 2) metres; none where it is too large.
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
    """Boxes of an object at footprint centres.

    Args:
        centres: (n, 2) metres.
        z: height it stands at, one or (n,).
        pose: orientation of the object.

    Returns:
        (n, 6) world metres.
    """
    half = pose.extent[:2] / 2
    bottom = np.broadcast_to(np.asarray(z, float), (len(centres),))[:, None] + LIFT_M
    return np.concatenate([centres - half, bottom, centres + half, bottom + pose.extent[2]], axis=1)


def clear(scene: Surroundings, boxes: Array) -> NDArray[np.bool_]:
    """Which boxes meet no part of anything; slanted parts are left to PyBullet.

    Args:
        scene: the home and its arrangement.
        boxes: (n, 6) metres.

    Returns:
        (n,) bool.
    """
    if not len(boxes):
        return np.zeros(0, bool)
    around = np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])
    rows = scene.parts_near(around)
    return are_clear(scene.parts.boxes[rows[~scene.parts.slanted[rows]]], boxes, _TOUCH_M)


def slots_at(centres: Array, z: float | Array, pose: SlotPose, order: NDArray[np.int64]) -> Iterator[Slot]:
    """Slots at some centres.

    Args:
        centres: (n, 2) metres.
        z: height to stand at, one or (n,).
        pose: orientation of the object.
        order: rows of ``centres``, in the order of the slots.
    """
    heights = np.broadcast_to(np.asarray(z, float), (len(centres),))
    offset = (pose.low + pose.high)[:2] / 2
    for k in order:
        x, y = centres[k] - offset
        yield Slot((float(x), float(y), float(heights[k] + LIFT_M - pose.low[2])), pose)


def nearest_node_m(scene: Surroundings, centres: Array, room: int) -> Array:
    """Distance from points to the nearest free node of a room: near things can be seen and reached.

    Args:
        scene: the home and its arrangement.
        centres: (n, 2) points, metres.
        room: its number.

    Returns:
        (n,) metres.
    """
    grid = scene.house.grid
    ox, oy = grid.origin_xy
    free = scene.free & (grid.room == room)
    return node_distances(free, ox, oy, GRID_M, np.ascontiguousarray(centres), _NODE_REACH)
