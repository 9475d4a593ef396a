"""A home with an arrangement as placement sees it: boxes of all parts, and all levels that things can stand on.

Built from arrays that are computed once per home; the arrangement's objects are appended.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.scenes.spec import WALL_THICKNESS_M
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import STRUCTURE, House
from ucon.sim.placement.kernels import rows_meeting
from ucon.sim.shapes import (
    Array,
    Solid,
    item_solid,
    item_turn,
    object_solid,
    object_turn,
    primitive_boxes,
    solid_of_parts,
)
from ucon.sim.structure import structure_parts

Index = NDArray[np.int64]
SURFACE, COMPARTMENT, FLOOR_LEVEL = 0, 1, 2
_STRAIGHT = 0.02
_UPRIGHT = 0.97
_FLAT_SHARE = 0.25


@dataclass(frozen=True, eq=False)
class Standing:
    """The pose of one instance: solid, position (3,) in world metres, rotation (3, 3)."""

    shape: Solid
    position: Array
    turn: Array


@dataclass(frozen=True, eq=False)
class Parts:
    """Boxes of m collision primitives."""

    boxes: Array
    """(m, 6) world metres."""
    owner: Index
    """(m,) instance of each."""
    number: Index
    """(m,) its number in the instance's solid."""
    slanted: NDArray[np.bool_]
    """(m,) whether the part is at an angle, so that its box is larger: only PyBullet can tell what it meets."""


@dataclass(frozen=True, eq=False)
class Levels:
    """Level rectangles that things can stand on, one per row."""

    box: Array
    """(n, 6) x0, y0, height of the level, x1, y1, height of what is above it; world metres."""
    owner: Index
    """(n,) instance of each."""
    kind: Index
    """(n,) SURFACE, COMPARTMENT or FLOOR_LEVEL."""
    number: Index
    """(n,) number of the surface, compartment or room."""
    hides: NDArray[np.bool_]
    """(n,) whether the owner must be opened to see it, or moves it when opened."""


@dataclass(frozen=True, eq=False)
class _Base:
    standing: tuple[Standing, ...]
    parts: Parts
    levels: Levels


_bases: WeakKeyDictionary[House, _Base] = WeakKeyDictionary()


class Surroundings:
    """A home with an arrangement, as placement sees it. All joints are closed.

    Attributes:
        house: the home.
        arrangement: the episode's changes.
        categories: of every instance.
        standing: pose of every instance.
        parts: boxes of all collision primitives that are present.
        levels: all levels that are present.
    """

    def __init__(self, house: House, arrangement: Arrangement) -> None:
        self.house = house
        self.arrangement = arrangement
        base = _base(house)
        added = [
            Standing(object_solid(placed), np.array(placed.position), object_turn(placed))
            for placed in arrangement.objects
        ]
        numbers = range(house.n_instances, house.n_instances + len(added))
        self.standing = (*base.standing, *added)
        self.categories = house.categories + tuple(placed.category for placed in arrangement.objects)
        own_parts, own_levels = _parts(added, numbers), _levels(added, numbers)
        gone = np.isin(base.parts.owner, arrangement.removed)
        keep = ~gone if gone.any() else slice(None)
        self.parts = _join_parts(base.parts, keep, own_parts)
        gone = np.isin(base.levels.owner, arrangement.removed)
        self.levels = _join_levels(base.levels, ~gone, own_levels)

    @cached_property
    def boxes(self) -> Array:
        """(n, 6) closed boxes of all instances, world metres."""
        own = [primitive_boxes(s.shape, s.position, s.turn) for s in self.standing[self.house.n_instances :]]
        rows = [np.concatenate([b[:, :3].min(axis=0), b[:, 3:].max(axis=0)]) for b in own]
        return np.concatenate([self.house.boxes, np.array(rows).reshape(-1, 6)])

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(nx, ny) bool, free nodes without those that objects block."""
        free = self.house.grid.free.copy()
        if self.arrangement.blocked:
            taken = np.array(self.arrangement.blocked)
            free[taken[:, 0], taken[:, 1]] = False
        return free

    def is_present(self, instance: int) -> bool:
        """Whether an instance exists and was not removed."""
        return 0 <= instance < len(self.categories) and instance not in self.arrangement.removed

    def mount(self, instance: int) -> str:
        """How an instance is mounted, by the catalogue; "structure" for structure."""
        category = self.categories[instance]
        return "structure" if category in STRUCTURE else catalogue()[category].mount

    def levels_of(self, instance: int, kind: int) -> Index:
        """Rows of :attr:`levels` of one kind that belong to an instance."""
        return np.flatnonzero((self.levels.owner == instance) & (self.levels.kind == kind))

    def parts_near(self, box: Array) -> Index:
        """Rows of :attr:`parts` that meet a box (6,)."""
        return rows_meeting(self.parts.boxes, np.asarray(box, float))

    def room_at(self, x: float, y: float, default: int) -> int:
        """Number of the room that contains a point; ``default`` outside all rooms."""
        grid = self.house.grid
        i, j = grid.cell((x, y))
        inside = 0 <= i < grid.shape[0] and 0 <= j < grid.shape[1]
        room = int(grid.room[i, j]) if inside else -1
        return room if room >= 0 else default

    def room_of(self, instance: int) -> int:
        """Number of an instance's room."""
        n = self.house.n_instances
        return int(self.house.instance_room[instance]) if instance < n else self.arrangement.objects[instance - n].room

    def holder_at(self, point: Array, but: int = -1) -> tuple[int, int]:
        """The container that hides or carries what is at a point.

        Args:
            point: (3,) world metres.
            but: an instance that is left out.

        Returns:
            Instance and compartment; (-1, -1) for none.
        """
        box = self.levels.box
        inside = (box[:, :3] <= point + 1e-6).all(axis=1) & (point <= box[:, 3:] + 1e-6).all(axis=1)
        rows = np.flatnonzero(inside & self.levels.hides & (self.levels.owner != but))
        return (int(self.levels.owner[rows[0]]), int(self.levels.number[rows[0]])) if len(rows) else (-1, -1)


def _base(house: House) -> _Base:
    if house not in _bases:
        _bases[house] = _make_base(house)
    return _bases[house]


def _make_base(house: House) -> _Base:
    spec = house.spec
    items = [Standing(item_solid(item), np.array(item.position), item_turn(item)) for item in spec.items]
    structure = [
        Standing(solid_of_parts(parts), np.zeros(3), np.eye(3))
        for _, _, parts in sorted(structure_parts(spec), key=lambda entry: (entry[0], STRUCTURE.index(entry[1])))
    ]
    standing = (*items, *structure)
    levels = _levels(items, range(len(items)))
    margin = WALL_THICKNESS_M / 2
    floors = [
        (r.rect[0] + margin, r.rect[1] + margin, 0.0, r.rect[2] - margin, r.rect[3] - margin, spec.wall_height_m)
        for r in spec.rooms
    ]
    rooms = np.arange(len(floors))
    floor_levels = Levels(
        np.array(floors),
        house.n_items + 3 * rooms,
        np.full(len(floors), FLOOR_LEVEL),
        rooms,
        np.zeros(len(floors), bool),
    )
    keep = np.ones(len(levels.owner), bool)
    return _Base(standing, _parts(standing, range(len(standing))), _join_levels(levels, keep, floor_levels))


def _parts(standing: tuple[Standing, ...] | list[Standing], numbers: range) -> Parts:
    boxes = [primitive_boxes(s.shape, s.position, s.turn) for s in standing]
    owner = [np.full(len(b), number) for b, number in zip(boxes, numbers, strict=True)]
    index = [np.arange(len(b)) for b in boxes]
    if not boxes:
        none = np.zeros(0, np.int64)
        return Parts(np.zeros((0, 6)), none, none, none.astype(bool))
    slanted = [_slanted(s) for s in standing]
    return Parts(np.concatenate(boxes), np.concatenate(owner), np.concatenate(index), np.concatenate(slanted))


def _slanted(standing: Standing) -> NDArray[np.bool_]:
    """Parts (k,) that are not turned by multiples of 90 degrees."""
    turn = np.abs(standing.turn @ standing.shape.turn)
    return np.asarray(((turn > _STRAIGHT) & (turn < 1 - _STRAIGHT)).any(axis=(1, 2)))


def _levels(standing: tuple[Standing, ...] | list[Standing], numbers: range) -> Levels:
    rows: list[tuple[Array, int, int, int, bool]] = []
    for number, s in zip(numbers, standing, strict=True):
        if s.turn[2, 2] < _UPRIGHT:
            # Lying on its side, a flat thing still has a level top, but a hollow one has no inside.
            rows += [(box, number, SURFACE, 0, False) for box in _lying_top(s)]
            continue
        for k, surface in enumerate(s.shape.model.surfaces):
            local = np.array([surface.x0, surface.y0, surface.z, surface.x1, surface.y1])
            box = turned_box(np.append(local, surface.z + surface.clearance_m), s)
            rows.append((box, number, SURFACE, k, False))
        for k, space in enumerate(s.shape.model.compartments):
            hides = bool(space.opened_by) or space.link >= 0
            rows.append((turned_box(np.array(space.box), s), number, COMPARTMENT, k, hides))
    if not rows:
        empty = np.zeros(0, np.int64)
        return Levels(np.zeros((0, 6)), empty, empty, empty, np.zeros(0, bool))
    return Levels(
        np.array([row[0] for row in rows]),
        np.array([row[1] for row in rows]),
        np.array([row[2] for row in rows]),
        np.array([row[3] for row in rows]),
        np.array([row[4] for row in rows]),
    )


def _lying_top(standing: Standing) -> list[Array]:
    """The upper face of a flat thing that has surfaces and lies on its side, as a level; nothing for other things."""
    boxes = primitive_boxes(standing.shape, standing.position, standing.turn)
    box = np.concatenate([boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)])
    flat = box[5] - box[2] < _FLAT_SHARE * min(box[3] - box[0], box[4] - box[1])
    if not flat or not standing.shape.model.surfaces:
        return []
    inset = 0.05 * (box[3:5] - box[:2])
    return [np.array([*(box[:2] + inset), box[5], *(box[3:5] - inset), box[5] + 1.0])]


def turned_box(local: Array, standing: Standing) -> Array:
    """World box (6,) of a box (6,) in an instance's object frame."""
    centre, half = (local[:3] + local[3:]) / 2, (local[3:] - local[:3]) / 2
    middle, reach = standing.turn @ centre + standing.position, np.abs(standing.turn) @ half
    return np.concatenate([middle - reach, middle + reach])


def _join_parts(a: Parts, keep: NDArray[np.bool_] | slice, b: Parts) -> Parts:
    return Parts(
        np.concatenate([a.boxes[keep], b.boxes]),
        np.concatenate([a.owner[keep], b.owner]),
        np.concatenate([a.number[keep], b.number]),
        np.concatenate([a.slanted[keep], b.slanted]),
    )


def _join_levels(a: Levels, keep: NDArray[np.bool_], b: Levels) -> Levels:
    return Levels(
        np.concatenate([a.box[keep], b.box]),
        np.concatenate([a.owner[keep], b.owner]),
        np.concatenate([a.kind[keep], b.kind]),
        np.concatenate([a.number[keep], b.number]),
        np.concatenate([a.hides[keep], b.hides]),
    )
