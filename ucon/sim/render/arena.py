"""The geometry that a renderer draws: a home, changed by an arrangement, with some joints open.

The polygons of a home are computed once and shared. An :class:`Arena` is one renderer's own copy, with the objects of
an episode; parts that move are computed again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ucon.core.geometry import axis_angle_matrix, matrix_from_quat, yaw_matrix
from ucon.core.jit import F32, F64, I32, jit
from ucon.objects.model import ObjectModel, Vec3
from ucon.scenes.spec import HomeSpec
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.render.shapes import BOTTOM, TOP
from ucon.sim.render.tables import Tables, bake, copied_tables, copy_tables, empty_tables, tables_nbytes, write_group
from ucon.sim.render.tessellate import CEILING, WALL, Mesh, mesh_of_model, mesh_of_parts
from ucon.sim.structure import structure_parts

ModelBuilder = Callable[[str, Vec3 | None, int], ObjectModel]
Pose = tuple[F64, F64]
"""Rotation (3, 3) and position (3,) of a model origin, world metres."""

_HOMES: WeakKeyDictionary[House, dict[ModelBuilder, Tables]] = WeakKeyDictionary()


def catalogue_model(category: str, size: Vec3 | None, tint: int) -> ObjectModel:
    """The catalogue's model of a category, size and colour variant."""
    from ucon.objects import build_model

    return build_model(category, size, tint)


@lru_cache(maxsize=4096)
def _mesh(builder: ModelBuilder, category: str, size: Vec3 | None, tint: int) -> tuple[ObjectModel, Mesh]:
    model = builder(category, size, tint)
    return model, mesh_of_model(model)


def home_tables(house: House, builder: ModelBuilder) -> Tables:
    """Polygons of the home without an arrangement, computed at the first call.

    Args:
        house: the home.
        builder: where models come from.
    """
    cached = _HOMES.setdefault(house, {})
    if builder not in cached:
        cached[builder] = _bake_home(house, builder)
    return cached[builder]


def _bake_home(house: House, builder: ModelBuilder) -> Tables:
    spec = house.spec
    meshes: list[tuple[Mesh, F64, F64, int]] = []
    for item in spec.items:
        mesh = _mesh(builder, item.category, item.size, item.tint)[1]
        meshes.append((mesh, yaw_matrix(item.quarter_turns), np.array(item.position), -1))
    for room, kind, parts in structure_parts(spec):
        look = CEILING if kind == "ceilings" else WALL
        looks = [int(p.material) if kind == "floors" or spec.rooms[room].outdoor else look for p in parts]
        face = {"floors": TOP, "ceilings": BOTTOM}.get(kind, -1)
        mesh = mesh_of_parts(parts, looks, face)
        meshes.append((mesh, np.eye(3), np.zeros(3), room))
    tables = empty_tables(len(meshes), *_sizes([mesh for mesh, *_ in meshes]))
    at = (0, 0, 0)
    for group, (mesh, turn, shift, room) in enumerate(meshes):
        at = write_group(tables, mesh, group, at, turn, shift, room)
    return tables


def _sizes(meshes: list[Mesh]) -> tuple[int, int, int]:
    return (
        sum(len(m.parts) for m in meshes),
        sum(len(m.normals) for m in meshes),
        sum(len(m.vertices) for m in meshes),
    )


class Arena:
    """One renderer's polygons of a home in an episode.

    Attributes:
        tables: polygons; written by :meth:`set_open`, and shared by deep copies until then.
        room_start: (nr + 1,) starts of the rooms in ``room_groups``.
        room_groups: groups that touch each room, ``room_groups[room_start[r]:room_start[r + 1]]``.
        rooms: (nr, 4) rectangles x0, y0, x1, y1, metres.
        portals: (n, 7) axis, coord, lo, hi, room a, room b, height.
    """

    def __init__(self, house: House, arrangement: Arrangement, builder: ModelBuilder = catalogue_model) -> None:
        self.house = house
        self.arrangement = arrangement
        self._builder = builder
        self._fractions: dict[int, float] = {}
        self._own = True
        base = home_tables(house, builder)
        added = [_mesh(builder, o.category, None, o.tint)[1] for o in arrangement.objects]
        counts = (len(base.groups), len(base.parts), len(base.face_planes), len(base.vertices))
        extra = (len(added), *_sizes(added))
        self.tables = empty_tables(*(a + b for a, b in zip(counts, extra, strict=True)))
        copy_tables(base, self.tables)
        at = counts[1:]
        for group, (mesh, placed) in enumerate(zip(added, arrangement.objects, strict=True), counts[0]):
            turn, shift = _placed_pose(placed)
            at = write_group(self.tables, mesh, group, at, turn, shift)
        for instance in arrangement.removed:
            self.tables.groups[instance, 1] = 0
        self.rooms, self.portals = _plan(house.spec)
        self._home_room = np.concatenate([house.instance_room, [o.room for o in arrangement.objects]]).astype(np.int32)
        self._carried = _carried_by(arrangement.objects, house.n_instances)
        self._tall = _tall_rooms(house.spec)
        self._list_rooms()

    def __deepcopy__(self, memo: dict[int, Any]) -> Arena:
        """A copy that shares all polygons until one of the two opens something."""
        memo[id(self)] = new = Arena.__new__(Arena)
        new.__dict__.update(self.__dict__)
        new._fractions = dict(self._fractions)
        self._own = new._own = False
        return new

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what is open; polygons are computed again."""
        return _opened, (self.house, self.arrangement, self._builder, self._fractions)

    @property
    def n_instances(self) -> int:
        """Number of instances of the home and objects of the episode."""
        return len(self.tables.groups)

    @property
    def nbytes(self) -> int:
        """Memory that belongs to this arena alone, bytes."""
        return tables_nbytes(self.tables) + self.room_groups.nbytes + self.room_start.nbytes

    def set_open(self, instance: int, fraction: float) -> list[int]:
        """Open all joints of an instance, with what its drawers hold.

        Args:
            instance: its number.
            fraction: of the travel, 0 to 1.

        Returns:
            Instances that moved.
        """
        model, mesh = self._model(instance)
        if not model.joints or self._fractions.get(instance, 0.0) == fraction:
            return []
        self._fractions[instance] = fraction
        if not self._own:
            self.tables, self._own = copied_tables(self.tables), True
        turn, shift = self._pose(instance)
        for link in range(len(model.joints)):
            self._bake_link(instance, mesh, (turn, shift), link)
        moved = [instance, *self._bake_content(instance)]
        self._list_rooms()
        return moved

    def _bake_link(self, instance: int, mesh: Mesh, pose: Pose, link: int) -> None:
        turn, shift = _compose(pose, self._link_motion(instance, link))
        bake(self.tables, mesh, instance, turn, shift, link)

    def _bake_content(self, holder: int) -> list[int]:
        """Compute again what the drawers of ``holder`` carry, and what that carries in turn."""
        moved = []
        for child in self._carried.get(holder, ()):
            model, mesh = self._model(child)
            pose = self._pose(child)
            bake(self.tables, mesh, child, *pose)
            for link in range(len(model.joints)):
                self._bake_link(child, mesh, pose, link)
            moved += [child, *self._bake_content(child)]
        return moved

    def _model(self, instance: int) -> tuple[ObjectModel, Mesh]:
        if instance < self.house.n_items:
            item = self.house.spec.items[instance]
            return _mesh(self._builder, item.category, item.size, item.tint)
        placed = self._placed(instance)
        return _mesh(self._builder, placed.category, None, placed.tint)

    def _placed(self, instance: int) -> PlacedObject:
        return self.arrangement.objects[instance - self.house.n_instances]

    def _pose(self, instance: int) -> Pose:
        """Pose of the model origin, moved with the drawer that it is in."""
        if instance < self.house.n_items:
            item = self.house.spec.items[instance]
            return yaw_matrix(item.quarter_turns), np.array(item.position)
        placed = self._placed(instance)
        pose = _placed_pose(placed)
        if placed.holder < 0:
            return pose
        closed, now = self._rest_pose(placed.holder), self._pose(placed.holder)
        if placed.compartment >= 0:
            link = self._model(placed.holder)[0].compartments[placed.compartment].link
            if link >= 0:
                now = _compose(now, self._link_motion(placed.holder, link))
        return _compose(_compose(now, _inverse(closed)), pose)

    def _rest_pose(self, instance: int) -> Pose:
        if instance < self.house.n_items:
            return self._pose(instance)
        return _placed_pose(self._placed(instance))

    def _link_motion(self, instance: int, link: int) -> Pose:
        """Motion of a link in the object frame, from closed to its current state."""
        joint = self._model(instance)[0].joints[link]
        value = joint.travel * self._fractions.get(instance, 0.0)
        axis, origin = np.array(joint.axis, float), np.array(joint.origin, float)
        if joint.kind == "prismatic":
            return np.eye(3), axis * value
        turn = axis_angle_matrix(axis, value)
        return turn, origin - turn @ origin

    def _list_rooms(self) -> None:
        """Put every group into the list of each room that its box touches."""
        groups = len(self.tables.groups)
        structure = (self.house.n_items, self.house.n_instances)
        pairs = np.empty(groups * len(self.rooms), np.int32)
        self.room_start = np.zeros(len(self.rooms) + 1, np.int32)
        count = _touching(
            self.tables.groups,
            self.tables.group_boxes,
            self.rooms,
            self._tall,
            self._home_room,
            structure,
            self.house.spec.wall_height_m,
            self.room_start,
            pairs,
        )
        self.room_groups = pairs[:count].copy()


def _opened(house: House, arrangement: Arrangement, builder: ModelBuilder, fractions: dict[int, float]) -> Arena:
    arena = Arena(house, arrangement, builder)
    for instance, fraction in fractions.items():
        arena.set_open(instance, fraction)
    return arena


def _placed_pose(placed: PlacedObject) -> Pose:
    return matrix_from_quat(np.array(placed.quat_xyzw)), np.array(placed.position, float)


def _compose(outer: Pose, inner: Pose) -> Pose:
    return outer[0] @ inner[0], outer[0] @ inner[1] + outer[1]


def _inverse(pose: Pose) -> Pose:
    return pose[0].T, -(pose[0].T @ pose[1])


def _carried_by(objects: tuple[PlacedObject, ...], first: int) -> dict[int, list[int]]:
    carried: dict[int, list[int]] = {}
    for number, placed in enumerate(objects, first):
        if placed.holder >= 0:
            carried.setdefault(placed.holder, []).append(number)
    return carried


def _plan(spec: HomeSpec) -> tuple[F32, F64]:
    rooms = np.array([room.rect for room in spec.rooms], np.float32).reshape(-1, 4)
    portals = [(o.axis, o.coord, o.lo, o.hi, o.room_a, o.room_b, o.height_m) for o in spec.openings]
    return rooms, np.array(portals, np.float64).reshape(-1, 7)


def _tall_rooms(spec: HomeSpec) -> I32:
    """Outdoor rooms: from each of them, things higher than the hedges of the others are visible."""
    return np.array([number for number, room in enumerate(spec.rooms) if room.outdoor], np.int32)


@jit
def _touching(
    groups: I32,
    boxes: F32,
    rooms: F32,
    outdoor: I32,
    home_room: I32,
    structure: tuple[int, int],
    height: float,
    start: I32,
    listed: I32,
) -> int:
    """Fill the room lists; structure is listed in its own room only. Returns the length of ``listed``."""
    count = 0
    for r in range(rooms.shape[0]):
        start[r] = count
        is_outdoor = False
        for k in range(outdoor.shape[0]):
            is_outdoor = is_outdoor or outdoor[k] == r
        for g in range(groups.shape[0]):
            if groups[g, 1] == 0:
                continue
            inside = home_room[g] == r
            if not inside and not structure[0] <= g < structure[1]:
                inside = (
                    boxes[g, 0] <= rooms[r, 2]
                    and boxes[g, 3] >= rooms[r, 0]
                    and boxes[g, 1] <= rooms[r, 3]
                    and boxes[g, 4] >= rooms[r, 1]
                ) or (is_outdoor and boxes[g, 5] > height)
            if inside:
                listed[count] = g
                count += 1
    start[rooms.shape[0]] = count
    return count
