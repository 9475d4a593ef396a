"""The specification of a home: rooms, openings, and every item with its pose. Plain data with one hash.

World frame: metres, z up, floor at z = 0; room edges are on the 0.25 m grid. Walls are 0.10 m thick and centred on the
grid line between rooms, so a room's free floor is its rectangle shrunk by 0.05 m.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Literal

from ucon.core.files import canonical_json, sha256_bytes
from ucon.objects.model import Material, Vec3

GRID_M = 0.25
WALL_THICKNESS_M = 0.10
LINTEL_M = 2.05


@dataclass(frozen=True)
class Room:
    """One rectangular room; ``rect`` is x0, y0, x1, y1 on the grid, metres."""

    name: str
    type: str
    rect: tuple[float, float, float, float]
    floor_color: tuple[int, int, int]
    floor_material: Material
    wall_color: tuple[int, int, int]
    outdoor: bool = False
    """Whether it has no ceiling, and hedges of full height for walls."""


@dataclass(frozen=True)
class Opening:
    """A hole in the wall between two rooms.

    Attributes:
        axis: 0: the wall is in the plane x = ``coord`` and the hole spans y in [lo, hi]; 1: x and y swapped.
        coord: of the plane, metres.
        lo: start of the hole.
        hi: its end.
        room_a: number of one room.
        room_b: number of the other.
        height_m: of the lintel; equal to the wall height for a full opening.
    """

    axis: Literal[0, 1]
    coord: float
    lo: float
    hi: float
    room_a: int
    room_b: int
    height_m: float = LINTEL_M


@dataclass(frozen=True)
class Item:
    """One object of the home."""

    category: str
    """Of the catalogue."""
    size: Vec3
    """Metres, before rotation."""
    position: Vec3
    """x and y of the centre of its footprint, z of its bottom; world metres."""
    quarter_turns: int
    """Rotation about z in steps of 90 degrees, counter-clockwise; the front looks along +x at 0."""
    room: int
    """Number of its room."""
    tint: int = 0
    """Colour variant of the category."""


@dataclass(frozen=True)
class HomeSpec:
    """A whole home. Equal specifications have equal hashes, in every process."""

    name: str
    """``Rs_int``; ``Rs_int~3`` (variant 3); ``procedural:house:17``."""
    kind: str
    wall_height_m: float
    rooms: tuple[Room, ...]
    openings: tuple[Opening, ...]
    items: tuple[Item, ...]

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the canonical JSON, with lengths rounded to 1e-6 m."""
        return sha256_bytes(canonical_json({f.name: _plain(getattr(self, f.name)) for f in fields(self)}).encode())

    @property
    def area_m2(self) -> float:
        """Floor area of all rooms, square metres."""
        return sum((r.rect[2] - r.rect[0]) * (r.rect[3] - r.rect[1]) for r in self.rooms)


def _plain(value: Any) -> Any:
    """Rooms, openings and items as dictionaries, tuples as lists, lengths rounded."""
    if isinstance(value, float):
        return round(value, 6) + 0.0
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Room | Opening | Item):
        return {name: _plain(item) for name, item in vars(value).items()}
    return value
