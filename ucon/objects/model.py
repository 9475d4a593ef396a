"""The parts of an object: primitives, joints, and the places where other things can be.

Object frame: origin at the centre of the footprint on the floor plane (z = 0 is the bottom), +x is the front, +y its
left, z up; metres. A model is a value: the same (category, size, tint) gives the same model.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Literal

Vec3 = tuple[float, float, float]
Box3 = tuple[float, float, float, float, float, float]
"""x0, y0, z0, x1, y1, z1 in metres."""

Shape = Literal["box", "cylinder", "sphere", "wedge"]
Relation = Literal["ontop", "inside", "under", "nextto"]
RELATIONS: tuple[Relation, ...] = ("ontop", "inside", "under", "nextto")
Spot = tuple[tuple[str, str], ...]
"""(relation, anchor category) pairs: of what holds a thing, then of what it stands next to; either may be missing."""


class Material(IntEnum):
    """Look of a surface; the renderer has one procedural texture for each."""

    PLAIN = 0
    WOOD = 1
    FABRIC = 2
    METAL = 3
    GLASS = 4
    TILE = 5
    PLASTER = 6
    PLANT = 7
    PAPER = 8
    PARQUET = 9
    CONCRETE = 10
    GRASS = 11


@dataclass(frozen=True, slots=True)
class Part:
    """One convex primitive.

    Attributes:
        shape: a cylinder stands along its own z; a sphere is an ellipsoid that fills ``size``; a wedge is a box whose
            top edge is at its own +x side (a ramp that rises along x).
        size: full extent before rotation, metres.
        center: in the object frame with all joints closed, metres.
        color: RGB, 0 to 255.
        material: look.
        rpy_rad: roll, pitch, yaw about fixed axes.
        link: joint that carries the part; -1 for the fixed base.
        taper: scale of a cylinder's top (0: cone, 1: cylinder).
    """

    shape: Shape
    size: Vec3
    center: Vec3
    color: tuple[int, int, int]
    material: Material = Material.PLAIN
    rpy_rad: Vec3 = (0.0, 0.0, 0.0)
    link: int = -1
    taper: float = 1.0


@dataclass(frozen=True, slots=True)
class Joint:
    """One degree of freedom: closed at 0, open at ``travel`` (radians or metres, always positive)."""

    kind: Literal["revolute", "prismatic"]
    origin: Vec3
    axis: Vec3
    travel: float


@dataclass(frozen=True, slots=True)
class Surface:
    """A level rectangle that things can stand on, in the object frame, metres."""

    x0: float
    y0: float
    x1: float
    y1: float
    z: float
    clearance_m: float
    """Free height above it."""
    link: int = -1


@dataclass(frozen=True, slots=True)
class Compartment:
    """A free space that can hold things.

    Attributes:
        box: in the object frame with all joints closed, metres.
        link: joint whose part carries the content (a drawer); -1: the content does not move.
        opened_by: joints that must be open to see into it; none for open shelves and baskets.
    """

    box: Box3
    link: int = -1
    opened_by: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class ObjectModel:
    """The shape of one category at one size."""

    category: str
    size: Vec3
    parts: tuple[Part, ...]
    joints: tuple[Joint, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    compartments: tuple[Compartment, ...] = ()
    under: tuple[Box3, ...] = ()
    """Free spaces below it (table, bed, chair, sink), down to z = 0."""
    mass_kg: float = 1.0
    simple_collision: bool = False
    """Whether it collides as one box (small movable things); else part by part (hollow things, furniture)."""

    @property
    def openable(self) -> bool:
        """Whether the action Open acts on it."""
        return bool(self.joints)


@dataclass(frozen=True, slots=True)
class Category:
    """One row of the catalogue. ``docs/DATA.md`` credits the sources of its numbers."""

    name: str
    archetype: str
    size: Vec3
    mass_kg: float
    color: tuple[int, int, int]
    mount: Literal["surface", "floor", "wall", "ceiling", "structure"]
    role: Literal["movable", "movable_furniture", "fixed", "fixed_furniture", "structure"]
    semantic_group: str
    openable: bool
    container: bool
    support: bool
    bottom_z_m: float
    rooms: tuple[str, ...]
    official_target: bool
    official_split: str
    note: str = ""

    @property
    def phrase(self) -> str:
        """The name with spaces: ``coffee_table`` becomes "coffee table"."""
        return self.name.replace("_", " ")
