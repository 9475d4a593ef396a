"""Import of anchors: an anchor that a home lacks is put where such a thing usually is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from ucon.core.geometry import yaw_matrix
from ucon.objects.catalogue import catalogue
from ucon.objects.model import Category
from ucon.scenes.spec import WALL_THICKNESS_M
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.placement import nextto, ontop
from ucon.sim.placement.common import PlacementRequest
from ucon.sim.placement.floor import can_spare, nodes_taken
from ucon.sim.placement.place import placed_object
from ucon.sim.placement.predicates import is_ontop
from ucon.sim.placement.reasons import Reason, RefusedError
from ucon.sim.placement.settle import Settled, settle
from ucon.sim.placement.slots import Slot, SlotPose, clear
from ucon.sim.placement.surroundings import SURFACE, Surroundings
from ucon.sim.shapes import Array, enclosing, primitive_boxes, solid

MAX_FOOTPRINT_M = 0.90
MAX_LENGTH_M = 1.60
"""Limit for long and light things: a chest, a rake, a guitar."""
MAX_WALL_WIDTH_M = 1.6
_ON_FLOOR = frozenset(
    {
        "axe",
        "backpack",
        "baseball_bat",
        "broom",
        "carton",
        "fishing_rod",
        "golf_club",
        "guitar",
        "hamper",
        "hockey_stick",
        "hoe",
        "hose",
        "log",
        "packing_box",
        "plywood",
        "shopping_basket",
        "shovel",
        "tennis_racket",
        "tote",
        "white_rice_sack",
    }
)
"""Categories that people lean on a wall or put on the floor, although they would fit on a table."""
_TRIES_A_SUPPORT = 4
_SUPPORTS = 10
_NEVER = frozenset({"window", "window_blind", "door", "gate", "garage_door"})
_HEIGHTS_M = (0.3, 1.3)
"""Heights of the tops of tables, counters, cabinets and shelves that anchors are put on, metres."""


def importable(category: str) -> bool:
    """Whether a category can be added to a home as an anchor: small and movable, or hung on a wall."""
    row = catalogue()[category]
    if category in _NEVER or row.mount in ("structure", "ceiling"):
        return False
    if row.mount == "wall":
        return not row.openable and row.size[1] <= MAX_WALL_WIDTH_M
    short, long = sorted(row.size[:2])
    if row.role == "movable":
        return short <= MAX_FOOTPRINT_M and long <= MAX_LENGTH_M
    return row.role == "movable_furniture" and long <= MAX_FOOTPRINT_M


def import_anchor(house: House, arrangement: Arrangement, category: str, rng: np.random.Generator) -> PlacedObject:
    """Put a category that a home lacks on a default support of a plausible room.

    Surface things go on a table, counter, shelf or cabinet; floor things along a wall; wall things on a free piece of
    wall. The catalogue's rooms come first.

    Args:
        house: the home.
        arrangement: what the episode changed so far.
        category: the anchor.
        rng: random numbers.

    Returns:
        The object with relation ``imported``; its ``anchor`` is what it stands on or hangs at.

    Raises:
        RefusedError: fixed furniture and structure cannot be imported, or no place is free.
    """
    if not importable(category):
        raise RefusedError("not_importable", f"{category} is fixed or too large to be brought into {house.spec.name}")
    row, scene = catalogue()[category], Surroundings(house, arrangement)
    shape = solid(category)
    reason: Reason = "no_free_slot"
    for room in _rooms(house, row, rng):
        for anchor, slot in _slots(scene, row, room, rng):
            request = PlacementRequest(scene, category, shape, anchor, rng)
            if not can_spare(scene, nodes_taken(scene, slot.box)):
                reason = "blocks_path"
                continue
            settled = _hung(slot, anchor) if row.mount == "wall" else settle(scene, shape, slot)
            if not isinstance(settled, Settled) or not _stands(request, settled):
                reason = "unstable"
                continue
            return replace(placed_object(request, "ontop", settled), relation="imported")
    raise RefusedError(reason, f"no place found in {house.spec.name} to bring in {category}")


def _rooms(house: House, row: Category, rng: np.random.Generator) -> list[int]:
    """Rooms in random order: those of the catalogue first, and in each group corridors and outdoor rooms last."""
    order = [int(r) for r in rng.permutation(len(house.spec.rooms))]
    kinds = [house.spec.rooms[r].type for r in range(len(house.spec.rooms))]
    return sorted(order, key=lambda r: (kinds[r] not in row.rooms, house.spec.rooms[r].outdoor, kinds[r] == "corridor"))


def _slots(scene: Surroundings, row: Category, room: int, rng: np.random.Generator) -> Iterator[tuple[int, Slot]]:
    if row.mount == "wall":
        yield from _on_wall(scene, row.name, room, rng)
        return
    on_floor = row.mount == "floor" or row.name in _ON_FLOOR
    stages = [_on_floor, _on_furniture] if on_floor else [_on_furniture, _on_floor]
    for stage in stages[:1] if row.mount == "floor" else stages:
        yield from stage(scene, row.name, room, rng)


def _on_floor(scene: Surroundings, category: str, room: int, rng: np.random.Generator) -> Iterator[tuple[int, Slot]]:
    walls = scene.house.n_items + 3 * room + 1
    request = PlacementRequest(scene, category, solid(category), walls, rng)
    for slot in islice(nextto.candidates(request), 20):
        yield walls - 1, slot


def _on_furniture(
    scene: Surroundings, category: str, room: int, rng: np.random.Generator
) -> Iterator[tuple[int, Slot]]:
    levels = scene.levels
    low, high = _HEIGHTS_M
    usual = (levels.kind == SURFACE) & (levels.box[:, 2] >= low) & (levels.box[:, 2] <= high)
    owners = [int(o) for o in np.unique(levels.owner[usual]) if scene.room_of(int(o)) == room]
    owners = [o for o in owners if catalogue()[scene.categories[o]].role in ("fixed_furniture", "movable_furniture")]
    for k in rng.permutation(len(owners))[:_SUPPORTS]:
        request = PlacementRequest(scene, category, solid(category), owners[k], rng)
        try:
            slots = ontop.candidates(request)
        except RefusedError:
            continue
        for slot in islice(slots, _TRIES_A_SUPPORT):
            if low <= slot.box[2] <= high + 0.01:
                yield owners[k], slot


def _on_wall(scene: Surroundings, category: str, room: int, rng: np.random.Generator) -> Iterator[tuple[int, Slot]]:
    """Free pieces of wall at the height of the catalogue, above furniture first."""
    shape, rect = solid(category), np.array(scene.house.spec.rooms[room].rect)
    bottom = min(catalogue()[category].bottom_z_m, scene.house.spec.wall_height_m - shape.extent[2] - 0.05)
    inner = rect + np.array([1, 1, -1, -1]) * (WALL_THICKNESS_M / 2 + 0.002)
    found: list[tuple[float, Slot]] = []
    for quarter in range(4):
        turn = yaw_matrix(quarter)
        box = enclosing(primitive_boxes(shape, (0.0, 0.0, 0.0), turn))
        axis, along = quarter % 2, 1 - quarter % 2
        wall = inner[axis] if quarter in (0, 1) else inner[2 + axis]
        at = wall - box[axis] if quarter in (0, 1) else wall - box[3 + axis]
        for t in np.arange(inner[along] - box[along] + 0.1, inner[2 + along] - box[3 + along] - 0.1, 0.1):
            position = np.zeros(3)
            position[axis], position[along], position[2] = at, t, max(bottom, 0.0) - box[2]
            slot = Slot((float(position[0]), float(position[1]), float(position[2])), _wall_pose(turn, box))
            if not _over_opening(scene, slot.box, axis, float(rect[axis if quarter in (0, 1) else 2 + axis])):
                found.append((float(rng.random()) - _furniture_below(scene, slot.box), slot))
    found.sort(key=lambda entry: entry[0])
    free = clear(scene, np.array([slot.box for _, slot in found]).reshape(-1, 6))
    for (_, slot), is_free in zip(found, free, strict=True):
        if is_free:
            yield scene.house.n_items + 3 * room + 1, slot


def _wall_pose(turn: Array, box: Array) -> SlotPose:
    return SlotPose(turn, box[:3], box[3:])


def _over_opening(scene: Surroundings, box: Array, axis: int, coord: float) -> bool:
    along = 1 - axis
    return any(
        o.axis == axis and abs(o.coord - coord) < 0.01 and box[along] < o.hi + 0.1 and box[3 + along] > o.lo - 0.1
        for o in scene.house.spec.openings
    )


def _furniture_below(scene: Surroundings, box: Array) -> float:
    levels = scene.levels
    middle = (box[:2] + box[3:5]) / 2
    near = ((levels.box[:, :2] - 0.25 <= middle) & (middle <= levels.box[:, 3:5] + 0.25)).all(axis=1)
    below = near & (levels.kind == SURFACE) & (levels.box[:, 2] > 0.3) & (levels.box[:, 2] < box[2])
    return 1.0 if below.any() else 0.0


def _hung(slot: Slot, walls: int) -> Settled:
    """The pose of what hangs on a wall: it is fixed and needs no settling."""
    return Settled(np.round(np.array(slot.position), 6), slot.pose.turn, frozenset({walls}))


def _stands(request: PlacementRequest, settled: Settled) -> bool:
    scene = request.scene
    box = enclosing(primitive_boxes(request.shape, settled.position, settled.turn))
    if request.row.mount != "wall" and not is_ontop(scene, request.anchor, box, settled.contacts):
        return False
    return can_spare(scene, nodes_taken(scene, box))
