"""Small hand-made homes for tests of the renderer: three rooms and a garden."""

from __future__ import annotations

import numpy as np

from ucon.core.rng import stream
from ucon.objects.model import RELATIONS, Compartment, Joint, Material, ObjectModel, Part, Vec3
from ucon.scenes.spec import GRID_M, HomeSpec, Item, Opening, Room
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House, NavGrid
from ucon.sim.render import RasterRenderer


def chest(size: Vec3) -> ObjectModel:
    """A drawer on slides in an open frame, with a door on a hinge above it."""
    x, y, z = size
    t = 0.02
    wood = (150, 105, 60)
    panels = (
        ((x, t, z), (0, -y / 2 + t / 2, z / 2)),
        ((x, t, z), (0, y / 2 - t / 2, z / 2)),
        ((t, y, z), (-x / 2 + t / 2, 0, z / 2)),
        ((x, y, t), (0, 0, z - t / 2)),
        ((x, y, t), (0, 0, z / 2)),
        ((x, y, t), (0, 0, t / 2)),
    )
    parts = [Part("box", s, c, wood, Material.WOOD) for s, c in panels]
    inner = (x - 2 * t, y - 2 * t, t)
    parts.append(Part("box", inner, (0, 0, 0.06), (200, 170, 120), Material.WOOD, link=0))
    parts.append(Part("box", (t, y - 2 * t, z / 2 - 0.06), (x / 2 - t / 2, 0, z / 4), (120, 80, 40), link=0))
    parts.append(Part("box", (t, y - 2 * t, z / 2 - 0.06), (x / 2 - t / 2, 0, 3 * z / 4), (90, 60, 30), link=1))
    joints = (
        Joint("prismatic", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 0.8 * x),
        Joint("revolute", (x / 2, y / 2 - t, 3 * z / 4), (0.0, 0.0, 1.0), 1.6),
    )
    drawer = Compartment((-x / 2, -y / 2, 0.08, x / 2, y / 2, z / 2), link=0, opened_by=(0,))
    return ObjectModel("chest", size, tuple(parts), joints, compartments=(drawer,))


def build(category: str, size: Vec3 | None, tint: int) -> ObjectModel:
    """Models of the hand-made homes."""
    x, y, z = size = size or (0.2, 0.16, 0.12)
    rng = np.random.default_rng(tint + 10 * len(category))
    color = tuple(int(c) for c in rng.integers(40, 230, 3))
    if category == "chest":
        return chest(size)
    if category == "ball":
        return ObjectModel(category, size, (Part("sphere", size, (0, 0, z / 2), color, Material.FABRIC),))
    if category == "jar":
        parts = (
            Part("cylinder", (x, y, 0.8 * z), (0, 0, 0.4 * z), color, Material.GLASS),
            Part("cylinder", (x, y, 0.2 * z), (0, 0, 0.9 * z), color, Material.METAL, taper=0.3),
        )
        return ObjectModel(category, size, parts)
    if category == "ramp":
        return ObjectModel(category, size, (Part("wedge", size, (0, 0, z / 2), color, Material.PAPER),))
    return ObjectModel(category, size, (Part("box", size, (0, 0, z / 2), color, Material.WOOD),))


def three_rooms() -> HomeSpec:
    """A living room, a kitchen and a hall that are joined by openings (one of full width), and a garden."""
    rooms = (
        Room("living", "living_room", (0.0, 0.0, 4.0, 5.0), (150, 110, 70), Material.PARQUET, (225, 215, 200)),
        Room("kitchen", "kitchen", (4.0, 0.0, 7.0, 3.0), (200, 200, 205), Material.TILE, (200, 220, 225)),
        Room("hall", "corridor", (4.0, 3.0, 7.0, 5.0), (120, 130, 140), Material.FABRIC, (230, 200, 190)),
        Room("garden", "garden", (7.0, 0.0, 11.0, 5.0), (90, 140, 70), Material.GRASS, (80, 130, 60), outdoor=True),
    )
    openings = (
        Opening(0, 4.0, 1.0, 2.0, 0, 1),
        Opening(0, 4.0, 3.0, 5.0, 0, 2, 2.5),
        Opening(1, 3.0, 5.0, 6.0, 1, 2),
        Opening(0, 7.0, 3.5, 4.5, 2, 3),
    )
    items = (
        Item("chest", (0.5, 0.8, 0.9), (0.35, 2.5, 0.0), 0, 0),
        Item("chest", (0.5, 0.6, 0.8), (5.5, 0.35, 0.0), 1, 1),
        Item("table", (1.2, 0.8, 0.7), (2.0, 4.0, 0.0), 0, 0),
        Item("ball", (0.4, 0.4, 0.4), (3.0, 0.6, 0.0), 0, 0, 3),
        Item("jar", (0.2, 0.2, 0.4), (2.0, 4.0, 0.7), 0, 0, 4),
        Item("ramp", (0.6, 0.5, 0.3), (6.4, 4.5, 0.0), 2, 2, 5),
        Item("tree", (0.8, 0.8, 3.4), (10.0, 1.0, 0.0), 0, 3, 6),
        Item("rug", (1.0, 0.7, 0.02), (4.0, 1.5, 0.0), 0, 0, 7),
    )
    return HomeSpec("three_rooms", "house", 2.5, rooms, openings, items)


def house_of(spec: HomeSpec) -> House:
    """A house whose free nodes are all those clear of the walls; only for rendering."""
    low = np.min([r.rect[:2] for r in spec.rooms], axis=0)
    shape = tuple(np.rint((np.max([r.rect[2:] for r in spec.rooms], axis=0) - low) / GRID_M).astype(int))
    free, room = np.zeros(shape, bool), np.full(shape, -1, np.int16)
    for number, r in enumerate(spec.rooms):
        i0, j0, i1, j1 = (round((v - o) / GRID_M) for v, o in zip(r.rect, (*low, *low), strict=True))
        room[i0:i1, j0:j1] = number
        free[i0 + 1 : i1 - 1, j0 + 1 : j1 - 1] = True
    boxes = np.zeros((len(spec.items) + 3 * len(spec.rooms), 6))
    return House(spec, NavGrid((float(low[0]), float(low[1])), free, room), boxes)


def frame(renderer: RasterRenderer, *camera: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    shape = (renderer.height, renderer.width)
    buffers = np.empty((*shape, 3), np.uint8), np.empty(shape, np.float32), np.empty(shape, np.int16)
    renderer.render(*camera, *buffers)
    return buffers


def camera_poses(house: House, count: int, key: str) -> list[tuple[float, float, float, int, int]]:
    """Random camera poses in rooms away from walls, and every third one in an opening."""
    random = stream(1, "poses", key, house.spec.name)
    poses = []
    openings = house.spec.openings
    for number in range(count):
        if openings and number % 3 == 0:
            hole = openings[random.integers(len(openings))]
            across = hole.coord + random.uniform(-0.12, 0.12)
            along = random.uniform(hole.lo + 0.15, hole.hi - 0.15)
            x, y = (across, along) if hole.axis == 0 else (along, across)
        else:
            x0, y0, x1, y1 = house.spec.rooms[random.integers(len(house.spec.rooms))].rect
            x, y = random.uniform(x0 + 0.15, x1 - 0.15), random.uniform(y0 + 0.15, y1 - 0.15)
        heading, pitch = int(random.integers(4)), int(random.integers(-2, 3) * 30)
        poses.append((float(x), float(y), 1.25, heading, pitch))
    return poses


def scattered(house: House, count: int, categories: tuple[str, ...]) -> Arrangement:
    """Objects in the air all over the home in random orientations, some of them across openings."""
    random = stream(2, "scatter", house.spec.name)
    objects = []
    for number in range(count):
        turn = random.normal(size=4)
        room = int(random.integers(len(house.spec.rooms)))
        x0, y0, x1, y1 = house.spec.rooms[room].rect
        place = [random.uniform(x0 + 0.3, x1 - 0.3), random.uniform(y0 + 0.3, y1 - 0.3), random.uniform(0.3, 1.8)]
        if house.spec.openings and number % 4 == 0:
            hole = house.spec.openings[random.integers(len(house.spec.openings))]
            place[hole.axis], place[1 - hole.axis] = hole.coord, (hole.lo + hole.hi) / 2
            room = hole.room_a
        category = categories[number % len(categories)]
        quat = tuple(float(v) for v in turn / np.linalg.norm(turn))
        objects.append(PlacedObject(category, tuple(float(v) for v in place), quat, room, RELATIONS[0], 0))
    return Arrangement(removed=(1, 2), objects=tuple(objects))
