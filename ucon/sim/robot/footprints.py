"""Footprints: the parts of collision solids that a robot can touch between two heights, seen from above.

The robot is an upright cylinder. It touches a solid where the part of the solid between its bottom and its top, laid
flat, is within its radius. A footprint is a convex polygon with a rounding: a box gives a polygon, an upright cylinder
or a ball one point and a radius. Tilted cylinders are prisms of 24 sides here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from ucon.scenes.spec import HomeSpec
from ucon.sim.arrangement import PlacedObject
from ucon.sim.shapes import (
    CYLINDER,
    SPHERE,
    Array,
    Solid,
    item_solid,
    item_turn,
    object_solid,
    object_turn,
    solid_of_parts,
)
from ucon.sim.structure import structure_parts

_SIDES: Final = 24
_UPRIGHT: Final = 1.0 - 1e-9
#: Corners of a box of half extents 1, and pairs of them that an edge joins.
_CORNERS: Final = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_EDGES: Final = np.array([(a, b) for a in range(8) for b in range(a) if (a ^ b) in (1, 2, 4)])


@dataclass(frozen=True, eq=False)
class Footprints:
    """The m footprints of some things.

    Attributes:
        points: the corners (k, 2) of each, counter-clockwise, world metres; one or two where it is round or thin.
        rounding: radius by which each is larger than its polygon, metres.
        owner: the instance that each belongs to.
    """

    points: tuple[Array, ...]
    rounding: tuple[float, ...]
    owner: tuple[int, ...]

    def __add__(self, other: Footprints) -> Footprints:
        return Footprints(self.points + other.points, self.rounding + other.rounding, self.owner + other.owner)


def home_footprints(spec: HomeSpec, low_m: float, high_m: float) -> Footprints:
    """Footprints of all items, walls and hedges of a home with everything closed.

    Args:
        spec: the home.
        low_m: bottom of the robot.
        high_m: its top.
    """
    found = Footprints((), (), ())
    for number, item in enumerate(spec.items):
        found += _of_solid(item_solid(item), np.array(item.position), item_turn(item), number, low_m, high_m)
    for room, kind, parts in structure_parts(spec):
        if kind == "walls" and parts:
            owner = len(spec.items) + 3 * room + 1
            found += _of_solid(solid_of_parts(parts), np.zeros(3), np.eye(3), owner, low_m, high_m)
    return found


def object_footprints(placed: PlacedObject, owner: int, low_m: float, high_m: float) -> Footprints:
    """Footprints of an object that an episode placed, as :func:`home_footprints`."""
    return _of_solid(object_solid(placed), np.array(placed.position), object_turn(placed), owner, low_m, high_m)


def _of_solid(shape: Solid, position: Array, turn: Array, owner: int, low_m: float, high_m: float) -> Footprints:
    """Footprints of the primitives of a solid that reach between the two heights."""
    centers, turns = shape.center @ turn.T + position, turn @ shape.turn
    points, rounding = [], []
    for kind, half, center, axes in zip(shape.kind, shape.half, centers, turns, strict=True):
        found = _of_primitive(int(kind), half, center, axes, low_m, high_m)
        if found is not None:
            points.append(found[0])
            rounding.append(found[1])
    return Footprints(tuple(points), tuple(rounding), (owner,) * len(points))


def _of_primitive(
    kind: int, half: Array, center: Array, axes: Array, low_m: float, high_m: float
) -> tuple[Array, float] | None:
    """Corners and rounding of one primitive; None where it does not reach between the heights."""
    if kind == SPHERE:
        off = max(0.0, center[2] - high_m, low_m - center[2])
        return None if off >= half[0] else (center[None, :2].copy(), float(np.sqrt(half[0] ** 2 - off**2)))
    upright = abs(axes[2, 2]) >= _UPRIGHT
    if upright and (center[2] - half[2] >= high_m or center[2] + half[2] <= low_m):
        return None
    if kind == CYLINDER:
        if upright:
            return center[None, :2].copy(), float(half[0])
        corners, edges = _prism(half)
    else:
        corners, edges = _CORNERS * half, _EDGES
    if upright:
        return _hull((corners @ axes.T + center)[:, :2]), 0.0
    cut = _between(corners @ axes.T + center, edges, low_m, high_m)
    return None if len(cut) == 0 else (_hull(cut[:, :2]), 0.0)


def _prism(half: Array) -> tuple[Array, np.ndarray]:
    """Corners (48, 3) and edges (72, 2) of a prism around a cylinder about z."""
    angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
    radius = half[0] / np.cos(np.pi / _SIDES)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)
    corners = np.concatenate([np.insert(ring, 2, -half[2], axis=1), np.insert(ring, 2, half[2], axis=1)])
    k = np.arange(_SIDES)
    after = (k + 1) % _SIDES
    pairs = [(k, after), (k + _SIDES, after + _SIDES), (k, k + _SIDES)]
    return corners, np.concatenate([np.stack(pair, 1) for pair in pairs])


def _between(corners: Array, edges: np.ndarray, low_m: float, high_m: float) -> Array:
    """Corners (n, 3) of the part of a convex solid between two heights; none where it does not reach there."""
    z = corners[:, 2]
    found = [corners[(z > low_m) & (z < high_m)]]
    for level in (low_m, high_m):
        a, b = corners[edges[:, 0]], corners[edges[:, 1]]
        crossed = (a[:, 2] - level) * (b[:, 2] - level) < 0
        a, b = a[crossed], b[crossed]
        found.append(a + (b - a) * ((level - a[:, 2]) / (b[:, 2] - a[:, 2]))[:, None])
    return np.concatenate(found)


def _hull(points: Array) -> Array:
    """Corners of the convex hull, counter-clockwise, relative positions kept to a hundredth of a millimetre."""
    origin = points[0]
    hull = cv2.convexHull((points - origin).astype(np.float32), returnPoints=False)
    return points[np.sort(hull.ravel()) if len(hull) < 3 else hull.ravel()]
