"""Programs of generated homes, drawn from :mod:`ucon.scenes.room_types`.

Each room gets the basic furniture of its type, and more by the statistics of the measured rooms
(:func:`ucon.scenes.program.type_stats`). Its size is drawn by its type; corridors grow with the rooms they lead to.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ucon.core.rng import stream
from ucon.objects.catalogue import catalogue
from ucon.scenes.program import HomeProgram, RoomProgram, TypeStats, type_stats
from ucon.scenes.room_types import BIG, CLUTTER, KIND_ROOMS, MUST, NO_WINDOWS, SIZES_M

MIN_ROOMS, MAX_ROOMS = 4, 15


def procedural_program(kind: str, seed: int) -> HomeProgram:
    """The program of a generated home.

    Args:
        kind: of :data:`ucon.scenes.program.HOME_KINDS`.
        seed: number of the home.
    """
    rng = stream(seed, "program", kind)
    always, pool, most = KIND_ROOMS[kind]
    n = int(rng.integers(MIN_ROOMS, min(most, MAX_ROOMS) + 1))
    types = list(always)
    weights = np.linspace(2.0, 1.0, len(pool))
    corridor = kind in ("house", "flat", "office") and n >= 6
    for index in rng.choice(len(pool), len(pool), replace=False, p=weights / weights.sum()):
        if len(types) + corridor >= n:
            break
        types.append(pool[int(index)])
    garden = kind == "house" and n < MAX_ROOMS and rng.random() < 0.2
    types += ["garden"] * garden + ["corridor"] * corridor
    names = numbered(types)
    hub = "corridor_0" if corridor else f"{always[0]}_0"
    edges = joined(names, types, hub, kind)
    rooms = tuple(drawn_room(name, room_type, kind, seed, edges) for name, room_type in zip(names, types, strict=True))
    height = 2.7 if kind in ("office", "shop", "restaurant") else float(rng.choice([2.4, 2.5, 2.7]))
    return HomeProgram(kind, height, hub, rooms, tuple(edges))


def numbered(types: list[str]) -> list[str]:
    """Names of rooms by their types: ``bedroom_0``, ``bedroom_1``."""
    seen: dict[str, int] = {}
    names = []
    for room_type in types:
        names.append(f"{room_type}_{seen.get(room_type, 0)}")
        seen[room_type] = seen.get(room_type, 0) + 1
    return names


#: Joint of a room to its parent where it is not a doorway.
_JOINTS = {
    "living_room": "opening_1.2",
    "kitchen": "opening_1.2",
    "entryway": "open",
    "lobby": "opening_2.0",
    "bar": "opening_2.0",
    "garden": "opening_1.5",
}


def joined(names: list[str], types: list[str], hub: str, kind: str) -> list[tuple[str, str, str]]:
    """Edges of the plan: kitchen to dining to living room, bathrooms and closets to bedrooms, the rest to the hub.

    Args:
        names: of the rooms, ``<type>_<number>``.
        types: of the rooms.
        hub: name of the room that all others are reached from.
        kind: of the home.

    Returns:
        (room nearer the hub, room, kind of opening), parents before children.
    """
    by_type: dict[str, list[str]] = {}
    for name, room_type in zip(names, types, strict=True):
        by_type.setdefault(room_type, []).append(name)
    edges = []
    for name, room_type in zip(names, types, strict=True):
        if name == hub:
            continue
        parent = _parent(room_type, int(name.rsplit("_", 1)[1]), hub, by_type, kind)
        wide = room_type == "dining_room" and parent != hub
        edges.append((parent, name, "opening_2.0" if wide else usual_joint(room_type)))
    reached = {hub}
    done: list[tuple[str, str, str]] = []
    while len(done) < len(edges):  # parents before children
        for edge in edges:
            if edge[0] in reached and edge[1] not in reached:
                reached.add(edge[1])
                done.append(edge)
    return done


def usual_joint(room_type: str) -> str:
    """The kind of opening between a room and the one it is reached from."""
    return _JOINTS.get(room_type, "doorway")


def _parent(room_type: str, number: int, hub: str, by_type: dict[str, list[str]], kind: str) -> str:
    """The room that a room opens to."""
    living = by_type.get("living_room", [hub])[0]
    sleepers = by_type.get("bedroom", []) + by_type.get("childs_room", [])
    if kind in ("house", "flat"):
        if room_type == "dining_room" and number == 0:
            return living
        if room_type == "kitchen":
            return by_type.get("dining_room", [living])[0]
    if room_type == "bathroom" and number > 0 and sleepers:
        return sleepers[(number - 1) % len(sleepers)]
    if room_type == "closet" and sleepers:
        return sleepers[number % len(sleepers)]
    if room_type == "pantry_room":
        return by_type.get("kitchen", [hub])[0]
    return living if room_type == "garden" else hub


def drawn_room(name: str, room_type: str, kind: str, seed: int, edges: Sequence[tuple[str, str, str]]) -> RoomProgram:
    """A room with a size and content drawn for its type.

    Args:
        name: of the room.
        room_type: its type, of :data:`ucon.scenes.room_types.SIZES_M`, or ``corridor``.
        kind: of the home.
        seed: of the home.
        edges: of the home; a corridor is longer the more rooms it leads to.
    """
    rng = stream(seed, "program", kind, name)
    public = kind in ("restaurant", "shop") and room_type in BIG and not (kind == "shop" and room_type != "bathroom")
    if room_type == "corridor":
        size = (1.5, max(4.0, 1.7 * sum(1 for e in edges if e[0] == name)))
    else:
        a, b, c, d = (BIG if public else SIZES_M)[room_type]
        size = (round(float(rng.uniform(a, b)) * 4) / 4, round(float(rng.uniform(c, d)) * 4) / 4)
    furniture = _furniture(room_type, kind, rng)
    surface = {c: int(rng.integers(1, 3)) for c, p in CLUTTER.get(room_type, ()) if rng.random() < p}
    fixtures = {"electric_switch": 1, "room_light": 2 if size[0] * size[1] > 30 else 1}
    if room_type not in NO_WINDOWS:
        fixtures["window"] = int(rng.integers(1, 3))
    return RoomProgram(name, room_type, size, furniture, surface, fixtures)


def _furniture(room_type: str, kind: str, rng: np.random.Generator) -> dict[str, int]:
    found: dict[str, int] = {}
    for category, least, most in MUST.get(room_type, ()):
        n = int(rng.integers(least, most + 1))
        if n:
            found[category] = n
    if room_type == "bathroom":
        wet = "shower_stall" if kind not in ("house", "flat") or rng.random() < 0.55 else "bathtub"
        if kind in ("house", "flat"):
            found[wet] = 1
        else:
            found.update(sink=2, mirror=2, toilet=2, toilet_paper_dispenser=2, hand_dryer=1)
    if room_type == "dining_room" and kind in ("restaurant", "shop"):
        found.update(breakfast_table=int(rng.integers(3, 6)), armchair=int(rng.integers(8, 13)), pot_plant=3)
        found.pop("straight_chair", None)
    if room_type == "shared_office":
        found["swivel_chair"] = found["monitor"] = found["desk"] = found["desk"] // 2 * 2
    return _sampled(found, type_stats().get(room_type), rng)


def _sampled(found: dict[str, int], stats: TypeStats | None, rng: np.random.Generator) -> dict[str, int]:
    """Add furniture by the statistics of measured rooms of the type."""
    for category, share, mean in stats.categories if stats else ():
        draw, amount = rng.random(), rng.poisson(max(mean - 1.0, 0.0))
        if category in found or category not in catalogue() or draw > share * 0.8:
            continue
        if category in ("window", "electric_switch", "downlight", "room_light", "bed", "swimming_pool", "car"):
            continue
        wide = float(np.prod(catalogue()[category].size[:2]))
        most = 1 if wide > 0.5 else 2 if wide > 0.15 else 4
        found[category] = int(min(1 + amount, most))
    return found
