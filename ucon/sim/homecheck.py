"""Checks of a compiled home read from a file: known categories, plausible sizes, rooms that exist."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.scenes.spec import HomeSpec, Item, Opening, Room
from ucon.sim.house import House
from ucon.sim.rooms import room_grid

#: Most nodes along each axis; the largest named home has 116.
MOST_NODES: Final = 2000


def require_usable(house: House, told: object) -> None:
    """Refuse a home whose content is implausible or whose hash differs from the one in the file.

    Args:
        house: the home.
        told: the hash in the file.

    Raises:
        ValueError: saying what is wrong, without naming the file.
    """
    _require_spec(house.spec)
    if house.spec.hash != told:
        raise ValueError("its content does not match its hash")
    origin, rooms = room_grid(house.spec)
    if house.grid.origin_xy != origin or not np.array_equal(house.grid.room, rooms):
        raise ValueError("its map of rooms does not match its rooms")
    if (house.grid.free & (rooms < 0)).any() or not house.grid.free.any():
        raise ValueError("free nodes outside all rooms, or none at all")
    if house.boxes.shape != (house.n_instances, 6) or not np.isfinite(house.boxes).all():
        raise ValueError(f"boxes of shape {house.boxes.shape}, expected ({house.n_instances}, 6) numbers")


def _require_spec(spec: HomeSpec) -> None:
    _expect(_is_name(spec.name) and _is_name(spec.kind), "name and kind")
    _expect(_are_numbers((spec.wall_height_m,)) and 1 <= spec.wall_height_m <= 20, "wall_height_m")
    _expect(0 < len(spec.rooms) <= 1000, "number of rooms")
    for number, room in enumerate(spec.rooms):
        _expect(_is_room(room), f"room {number}")
    for number, opening in enumerate(spec.openings):
        _expect(_is_opening(opening, len(spec.rooms)), f"opening {number}")
    for number, item in enumerate(spec.items):
        _expect(_is_item(item, len(spec.rooms)), f"item {number}")


def _is_room(room: Room) -> bool:
    names = _is_name(room.name) and _is_name(room.type) and type(room.outdoor) is bool
    if not (names and _are_numbers(room.rect, 4) and _is_color(room.floor_color) and _is_color(room.wall_color)):
        return False
    x0, y0, x1, y1 = room.rect
    return -500 <= x0 < x1 <= 500 and -500 <= y0 < y1 <= 500


def _is_opening(opening: Opening, rooms: int) -> bool:
    numbers = _are_numbers((opening.coord, opening.lo, opening.hi, opening.height_m))
    between = _is_index(opening.room_a, rooms) and _is_index(opening.room_b, rooms)
    return numbers and between and _is_index(opening.axis, 2) and opening.lo < opening.hi


def _is_item(item: Item, rooms: int) -> bool:
    named = isinstance(item.category, str) and item.category in catalogue()
    numbers = _are_numbers(item.size, 3) and _are_numbers(item.position, 3)
    turned = _is_index(item.quarter_turns, 4) and type(item.tint) is int and 0 <= item.tint < 1 << 31
    return named and numbers and turned and _is_index(item.room, rooms) and 0 < min(item.size) <= max(item.size) < 100


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 200 and value.isprintable()


def _is_color(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 3 and all(_is_index(part, 256) for part in value)


def _is_index(value: Any, below: int) -> bool:
    return type(value) is int and 0 <= value < below


def _are_numbers(values: Any, count: int | None = None) -> bool:
    """Finite numbers of a size that homes have."""
    if not isinstance(values, tuple) or (count is not None and len(values) != count):
        return False
    return all(type(v) in (int, float) and math.isfinite(v) and abs(v) < 1e4 for v in values)


def _expect(right: bool, what: str) -> None:
    if not right:
        raise ValueError(f"{what} is invalid")
