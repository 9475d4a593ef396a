"""Collision shapes as plain arrays, for PyBullet bodies, boxes and placement. PyBullet is not needed here.

A :class:`Solid` has the collision primitives of one (category, size): boxes, cylinders and spheres in the object frame
with joints closed. Tapered cylinders collide as full ones, wedges and uneven spheres as boxes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import matrix_from_quat, matrix_from_rpy, yaw_matrix
from ucon.objects.model import ObjectModel, Part, Vec3
from ucon.objects.models import build_model
from ucon.scenes.spec import Item
from ucon.sim.arrangement import PlacedObject

BOX, CYLINDER, SPHERE = 0, 1, 2
_UNEVEN = 0.02
"""Round parts whose extents differ by more than this fraction collide as boxes."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solid:
    """The k collision primitives of one model."""

    model: ObjectModel
    kind: NDArray[np.int8]  # (k,) BOX, CYLINDER or SPHERE
    half: Array  # (k, 3) half extents before rotation; a cylinder's axis is its z
    center: Array  # (k, 3) in the object frame, joints closed
    turn: Array  # (k, 3, 3)
    link: NDArray[np.int16]  # (k,) joint that carries the primitive, -1 for the base
    bounds: Array
    """(6,) box in the object frame, metres."""

    @property
    def extent(self) -> Array:
        """(3,) size of the object-frame box, metres."""
        return self.bounds[3:] - self.bounds[:3]


@lru_cache(maxsize=4096)
def solid(category: str, size: Vec3 | None = None) -> Solid:
    """The collision primitives of a category.

    Args:
        category: of the catalogue.
        size: metres; None: the catalogue's.
    """
    return solid_of_model(build_model(category, size))


def solid_of_model(model: ObjectModel) -> Solid:
    """The collision primitives of a model; one box of its outer size if it has ``simple_collision``."""
    result = _from_parts(model, model.parts)
    if not model.simple_collision:
        return result
    low, high = result.bounds[:3], result.bounds[3:]
    return Solid(
        model,
        np.array([BOX], np.int8),
        (high - low)[None] / 2,
        (high + low)[None] / 2,
        np.eye(3)[None],
        np.array([-1], np.int16),
        result.bounds,
    )


def solid_of_parts(parts: tuple[Part, ...]) -> Solid:
    """The collision primitives of loose parts (walls, floors), in the frame of the parts."""
    return _from_parts(ObjectModel("parts", (0.0, 0.0, 0.0), parts), parts)


def _from_parts(model: ObjectModel, parts: tuple[Part, ...]) -> Solid:
    kind = np.array([_kind(part) for part in parts], np.int8)
    half = np.array([part.size for part in parts], float).reshape(-1, 3) / 2
    round_half = half[:, :2].mean(axis=1)
    half[kind == CYLINDER, :2] = round_half[kind == CYLINDER, None]
    half[kind == SPHERE] = round_half[kind == SPHERE, None]
    center = np.array([part.center for part in parts], float).reshape(-1, 3)
    turn = np.array([_turn(part.rpy_rad) for part in parts], float).reshape(-1, 3, 3)
    link = np.array([part.link for part in parts], np.int16)
    each = _boxes(kind, half, center, turn)
    bounds = np.concatenate([each[:, :3].min(axis=0), each[:, 3:].max(axis=0)]) if len(parts) else np.zeros(6)
    return Solid(model, kind, half, center, turn, link, bounds)


def _kind(part: Part) -> int:
    x, y, z = part.size
    if part.shape == "cylinder" and abs(x - y) <= _UNEVEN * max(x, y):
        return CYLINDER
    if part.shape == "sphere" and max(part.size) - min(part.size) <= _UNEVEN * max(x, y, z):
        return SPHERE
    return BOX


def _turn(rpy_rad: Vec3) -> Array:
    if not any(rpy_rad):
        return np.eye(3)
    turn = matrix_from_rpy(rpy_rad)
    turn[np.abs(turn) < 1e-12] = 0.0
    return turn


def _boxes(kind: NDArray[np.int8], half: Array, center: Array, turn: Array) -> Array:
    """Axis-aligned boxes (k, 6) of primitives."""
    extent = np.einsum("kij,kj->ki", np.abs(turn), half)
    if (kind != BOX).any():
        axis = turn[:, :, 2]
        rim = np.sqrt(np.maximum(0.0, 1.0 - axis * axis)) * half[:, :1]
        extent = np.where((kind == CYLINDER)[:, None], np.abs(axis) * half[:, 2:] + rim, extent)
        extent = np.where((kind == SPHERE)[:, None], half, extent)
    return np.concatenate([center - extent, center + extent], axis=1)


def primitive_boxes(shape: Solid, position: Array | Vec3, turn: Array) -> Array:
    """World boxes of the primitives of a solid.

    Args:
        shape: the solid.
        position: (3,) of the model origin, world metres.
        turn: (3, 3) rotation.

    Returns:
        (k, 6) x0 y0 z0 x1 y1 z1 in metres.
    """
    center = shape.center @ turn.T + np.asarray(position, float)
    return _boxes(shape.kind, shape.half, center, turn @ shape.turn)


def enclosing(boxes: Array) -> Array:
    """The box (6,) around boxes (k, 6)."""
    return np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])


def item_solid(item: Item) -> Solid:
    """The collision primitives of an item of a home."""
    return solid(item.category, item.size)


def item_turn(item: Item) -> Array:
    """Exact rotation (3, 3) of an item."""
    return yaw_matrix(item.quarter_turns)


def object_solid(placed: PlacedObject) -> Solid:
    """The collision primitives of an object that an episode adds."""
    return solid(placed.category)


def object_turn(placed: PlacedObject) -> Array:
    """Rotation (3, 3) of an object that an episode adds."""
    return matrix_from_quat(np.array(placed.quat_xyzw))


def item_box(item: Item) -> Array:
    """World box (6,) of an item with its joints closed, metres."""
    return enclosing(primitive_boxes(item_solid(item), item.position, item_turn(item)))


def object_box(placed: PlacedObject) -> Array:
    """World box (6,) of a placed object with all joints closed, metres."""
    return enclosing(primitive_boxes(object_solid(placed), placed.position, object_turn(placed)))


def quat_of_matrix(turn: Array) -> tuple[float, float, float, float]:
    """Unit quaternion ``xyzw`` of a rotation matrix (3, 3), with the largest component positive."""
    return _quat_of(np.ascontiguousarray(turn, float).tobytes())


@lru_cache(maxsize=4096)
def _quat_of(matrix: bytes) -> tuple[float, float, float, float]:
    """As :func:`quat_of_matrix`, cached by the matrix's bytes: a home has thousands of parts but few rotations."""
    m = np.frombuffer(matrix).reshape(3, 3)
    trace = np.array([m[0, 0] - m[1, 1] - m[2, 2], m[1, 1] - m[0, 0] - m[2, 2], m[2, 2] - m[0, 0] - m[1, 1]])
    squares = np.append(trace, m[0, 0] + m[1, 1] + m[2, 2])
    k = int(np.argmax(squares))
    rows = (
        (squares[0] + 1, m[1, 0] + m[0, 1], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]),
        (m[1, 0] + m[0, 1], squares[1] + 1, m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]),
        (m[0, 2] + m[2, 0], m[2, 1] + m[1, 2], squares[2] + 1, m[1, 0] - m[0, 1]),
        (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3] + 1),
    )
    quat = np.array(rows[k]) / np.linalg.norm(rows[k])
    x, y, z, w = (float(v) for v in quat)
    return x, y, z, w
