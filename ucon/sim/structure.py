"""Floors, walls, ceilings and hedges of a home as parts, for PyBullet bodies and for polygons.

Each side of a wall belongs to the room it faces: a box of half the wall's thickness on that room's side of the grid
line, in that room's colour. So all geometry of a room is inside its rectangle, which portal culling needs, and the
jambs of an opening are simply the ends of the wall boxes.
"""

from __future__ import annotations

from typing import Literal

from ucon.objects.model import Material, Part
from ucon.scenes.spec import WALL_THICKNESS_M, HomeSpec, Opening, Room

Kind = Literal["floors", "walls", "ceilings"]

FLOOR_THICKNESS_M = 0.05
CEILING_THICKNESS_M = 0.02
CEILING_COLOR = (244, 243, 238)
HEDGE_COLOR = (74, 122, 58)
_LEAST_M = 1e-6


def structure_parts(spec: HomeSpec) -> list[tuple[int, Kind, tuple[Part, ...]]]:
    """Parts in the world frame as ``(room, kind, parts)``, three entries per room in the order of the instances.

    The top of a floor is at z = 0, the underside of a ceiling at the wall height. A floor is seen from above only and a
    ceiling from below only, although both are thin slabs. Outdoor rooms have hedges for walls and no ceiling.
    """
    structure: list[tuple[int, Kind, tuple[Part, ...]]] = []
    for number, room in enumerate(spec.rooms):
        structure.append((number, "floors", (_floor(room),)))
        structure.append((number, "walls", tuple(_walls(spec, number))))
        structure.append((number, "ceilings", () if room.outdoor else (_ceiling(room, spec.wall_height_m),)))
    return structure


def _floor(room: Room) -> Part:
    box = (*room.rect[:2], -FLOOR_THICKNESS_M, *room.rect[2:], 0.0)
    return _box(box, room.floor_color, room.floor_material)


def _ceiling(room: Room, height_m: float) -> Part:
    box = (*room.rect[:2], height_m, *room.rect[2:], height_m + CEILING_THICKNESS_M)
    return _box(box, CEILING_COLOR, Material.PLASTER)


def _walls(spec: HomeSpec, number: int) -> list[Part]:
    """Boxes along the four sides of a room, split at its openings."""
    room = spec.rooms[number]
    color, material = (HEDGE_COLOR, Material.PLANT) if room.outdoor else (room.wall_color, Material.PLASTER)
    x0, y0, x1, y1 = room.rect
    half = WALL_THICKNESS_M / 2
    parts = []
    for axis, coord, inner, lo, hi in (
        (0, x0, x0 + half, y0, y1),
        (0, x1, x1 - half, y0, y1),
        (1, y0, y0 + half, x0, x1),
        (1, y1, y1 - half, x0, x1),
    ):
        holes = [o for o in spec.openings if number in (o.room_a, o.room_b) and _on_side(o, axis, coord)]
        for a, b, z0 in _pieces(lo, hi, holes):
            if b - a < _LEAST_M or spec.wall_height_m - z0 < _LEAST_M:
                continue
            near, far = min(coord, inner), max(coord, inner)
            plan = (near, a, far, b) if axis == 0 else (a, near, b, far)
            box = (plan[0], plan[1], z0, plan[2], plan[3], spec.wall_height_m)
            parts.append(_box(box, color, material))
    return parts


def _on_side(opening: Opening, axis: int, coord: float) -> bool:
    return opening.axis == axis and abs(opening.coord - coord) < _LEAST_M


def _pieces(lo: float, hi: float, holes: list[Opening]) -> list[tuple[float, float, float]]:
    """(from, to, bottom) of the wall pieces along one side: whole ones, and lintels over the holes."""
    pieces = []
    start = lo
    for hole in sorted(holes, key=lambda o: o.lo):
        left, right = max(hole.lo, lo), min(hole.hi, hi)
        pieces += [(start, left, 0.0), (left, right, hole.height_m)]
        start = right
    return [*pieces, (start, hi, 0.0)]


def _box(box: tuple[float, ...], color: tuple[int, int, int], material: Material) -> Part:
    x0, y0, z0, x1, y1, z1 = box
    size = (x1 - x0, y1 - y0, z1 - z0)
    return Part("box", size, ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2), color, material)
