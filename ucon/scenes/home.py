"""Builds a home: floor plan, openings, colours, furniture, fixtures. Everything is seeded by name and room."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from ucon.core.rng import stream
from ucon.objects.catalogue import catalogue
from ucon.scenes.colors import floor_of, wall_colors
from ucon.scenes.furnishing.canvas import Canvas
from ucon.scenes.furnishing.enrich import enriched
from ucon.scenes.furnishing.fixtures import LIGHTS, Fixer, door_frame
from ucon.scenes.furnishing.furnish import Furnisher
from ucon.scenes.furnishing.small_things import SmallThings
from ucon.scenes.layout import lay_out
from ucon.scenes.openings import cut_openings
from ucon.scenes.program import HomeProgram, RoomProgram
from ucon.scenes.spec import GRID_M, HomeSpec, Item, Opening, Room
from ucon.scenes.tidy import FloorPlan

N_TRIES = 3
OUTDOOR_HEIGHT_M = 20.0
YARD_CELLS = 12
"""A wall is an outside wall if there is no room within this many cells (3 m) behind it."""
EARLY_HUNG = ("radiator", "urinal")
WALL_FIRST = ("wall_mounted_tv", "mirror", "painting", "picture", "poster")


@dataclass(frozen=True)
class BuiltHome:
    """A home, and by room the items of its program that found no place."""

    spec: HomeSpec
    dropped: dict[str, dict[str, int]]


def build_home(name: str, program: HomeProgram, seed: int) -> BuiltHome:
    """Build the home of a program, adding furniture that measured inventories lack.

    Args:
        name: of the home.
        program: its rooms and furniture.
        seed: of all random choices.
    """
    return build_program(name, enriched(program, seed), seed)


def build_program(name: str, program: HomeProgram, seed: int) -> BuiltHome:
    """As :func:`build_home`, but with only the furniture of the program.

    Args:
        name: of the home.
        program: its rooms and furniture.
        seed: of all random choices.
    """
    plan = lay_out(program, seed, name)
    programs = {room.name: room for room in program.rooms}
    wishes = [_wishes(room_name, programs) for room_name in plan.names]
    low = np.array(plan.rects)[:, :2].min(0)
    rects = [tuple(float(v - low[k % 2]) * GRID_M for k, v in enumerate(r)) for r in plan.rects]
    plan.rects = [(r[0] - int(low[0]), r[1] - int(low[1]), r[2] - int(low[0]), r[3] - int(low[1])) for r in plan.rects]
    openings = cut_openings(plan, seed, program.wall_height_m)
    types = [w.type for w in wishes]
    walls = wall_colors(types, seed)
    rooms, items, dropped = [], [], {}
    for index, wish in enumerate(wishes):
        color, material = floor_of(wish.type, seed, wish.name)
        rect = (rects[index][0], rects[index][1], rects[index][2], rects[index][3])
        rooms.append(Room(wish.name, wish.type, rect, color, material, walls[index], wish.type == "garden"))
        found, missing = furnish_room(index, rect, plan, openings, wish, program.wall_height_m, seed)
        items += found
        if missing:
            dropped[wish.name] = dict(sorted(missing.items()))
    for (_, _, joint), opening in zip(plan.edges, openings, strict=True):
        if joint == "doorway":
            items.append(door_frame(opening, opening.room_b, int(stream(seed, "doors").integers(0, 6))))
    spec = HomeSpec(name, program.kind, program.wall_height_m, tuple(rooms), openings, tuple(items))
    return BuiltHome(spec, dropped)


def _wishes(name: str, programs: dict[str, RoomProgram]) -> RoomProgram:
    if name in programs:
        return programs[name]
    leg = programs[name.removesuffix("_b")]  # second leg of a folded corridor
    return RoomProgram(
        name, leg.type, leg.size_m, {"picture": 2, "pot_plant": 1}, {}, {"electric_switch": 1, "room_light": 1}
    )


def exterior_walls(plan: FloorPlan, index: int) -> list[tuple[int, float, float]]:
    """The stretches of a room's walls without a room behind them.

    Args:
        plan: the floor plan.
        index: number of the room.

    Returns:
        (wall, lo, hi) in metres.
    """
    rect = plan.rects[index]
    found = []
    for wall in range(4):
        axis = wall % 2
        coord = rect[wall]
        span = np.ones(rect[3 - axis] - rect[1 - axis], bool)
        for other_index, other in enumerate(plan.rects):
            near = coord - other[2 + axis] if wall < 2 else other[axis] - coord
            if other_index != index and 0 <= near < YARD_CELLS:
                low = max(other[1 - axis], rect[1 - axis]) - rect[1 - axis]
                high = min(other[3 - axis], rect[3 - axis]) - rect[1 - axis]
                span[max(low, 0) : max(high, 0)] = False
        edges = np.flatnonzero(np.diff(np.concatenate(([0], span.astype(int), [0]))))
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            found.append((wall, float(rect[1 - axis] + start) * GRID_M, float(rect[1 - axis] + end) * GRID_M))
    return found


def furnish_room(
    index: int,
    rect: tuple[float, float, float, float],
    plan: FloorPlan,
    openings: tuple[Opening, ...],
    wish: RoomProgram,
    wall_height_m: float,
    seed: int,
) -> tuple[list[Item], Counter[str]]:
    """Furnish one room; up to three tries while large things find no place, of which the best is kept.

    Args:
        index: number of the room.
        rect: x0, y0, x1, y1, metres.
        plan: the floor plan.
        openings: of the home.
        wish: what the room should hold.
        wall_height_m: of the home.
        seed: of the home.

    Returns:
        Items, and by category how many found no place.
    """
    best: tuple[float, list[Item], Counter[str]] | None = None
    for attempt in range(N_TRIES):
        height = OUTDOOR_HEIGHT_M if wish.type == "garden" else wall_height_m
        canvas = Canvas(index, rect, height)
        for o in openings:
            if index in (o.room_a, o.room_b):
                canvas.add_opening(o.axis, o.coord, o.lo, o.hi, o.height_m)
        key = wish.name if attempt == 0 else f"{wish.name}#{attempt}"
        missing = _fill(canvas, wish, exterior_walls(plan, index), seed, key, windows_late=attempt > 0)
        cost = _regret(missing)
        if best is None or cost < best[0]:
            best = cost, canvas.items, missing
        if cost == 0:
            break
    assert best is not None
    return best[1], best[2]


def _regret(missing: Counter[str]) -> float:
    """Floor area of the furniture that found no place, square metres."""
    book = catalogue()
    stands = [c for c in missing if (book[c].mount == "floor" or c in EARLY_HUNG) and book[c].role != "movable"]
    return float(sum(missing[c] * np.prod(book[c].size[:2]) for c in stands))


def _fill(
    canvas: Canvas,
    wish: RoomProgram,
    exterior: list[tuple[int, float, float]],
    seed: int,
    key: str,
    windows_late: bool,
) -> Counter[str]:
    fixer = Fixer(canvas, exterior, seed, key)
    floor, hung, surface = _sort(wish)
    late_windows = windows_late or wish.type in ("kitchen", "bathroom", "pantry_room", "utility_room")
    n_windows = 0 if wish.type == "garden" else wish.fixtures.get("window", 0)
    fixer.switches(0 if wish.type == "garden" else wish.fixtures.get("electric_switch", 0))
    if not late_windows:
        fixer.windows(n_windows)
    for category in EARLY_HUNG:  # they reach down to where furniture would stand
        if category in floor:
            fixer.hang(category, floor.pop(category))
    furnisher = Furnisher(canvas, wish.type, floor, seed, key)
    left = furnisher.run()
    for category in sorted(hung, key=lambda c: (c not in WALL_FIRST, c)):
        if category in left and left[category] > 0:
            fixer.hang(category, left.pop(category))
    if late_windows:
        fixer.windows(n_windows)
    if wish.type != "garden":
        for light in LIGHTS:
            if n := wish.fixtures.get(light, 0) + left.pop(light, 0):
                fixer.lights(light, n)
        if not any(wish.fixtures.get(light) for light in LIGHTS):
            fixer.lights("room_light", 1)
    on_tops = surface_like(left)
    things = SmallThings(canvas, seed, key)
    things.put({**surface, **{c: left[c] for c in on_tops}})
    for c in on_tops:
        left.pop(c)
    return +(left + (fixer.missing + things.missing))


def surface_like(left: Counter[str]) -> list[str]:
    """The categories among ``left`` that can stand on furniture, sorted."""
    book = catalogue()
    small = [c for c in left if left[c] > 0 and float(np.prod(book[c].size[:2])) < 0.2 and book[c].size[2] < 0.8]
    small += [c for c in ("standing_tv",) if left[c] > 0]
    return sorted(c for c in small if book[c].mount in ("surface", "floor"))


def _sort(wish: RoomProgram) -> tuple[dict[str, int], list[str], dict[str, int]]:
    """Split the furniture into floor and wall items (counts), the hung categories, and small things."""
    book = catalogue()
    surface = dict(wish.surface)
    floor: dict[str, int] = {}
    hung: list[str] = []
    for category, n in sorted(wish.furniture.items()):
        if category not in book:
            continue
        mount = book[category].mount
        if mount == "surface" or category in ("monitor", "table_lamp", "burner"):
            surface[category] = surface.get(category, 0) + n
            continue
        floor[category] = n
        if mount == "wall":
            hung.append(category)
    return floor, hung, surface
