"""From a room program to a floor plan: rectangles on the 0.25 m grid, and one opening for every edge.

Rooms grow outwards from the hub. Each room tries every place along its parent's walls that is flush with an
existing edge and takes the one that keeps the outline compact. Several seeded plans are drawn and the best is kept; if
none works, :func:`block_plan` always does. All lengths here are whole grid cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ucon.core.errors import SceneError
from ucon.core.rng import stream
from ucon.scenes.program import HomeProgram, RoomProgram
from ucon.scenes.spec import GRID_M
from ucon.scenes.tidy import FloorPlan, Rect, pad, plan_cost, shared_wall, trim_corridors

#: Least sides of rooms, so that five nodes remain free next to a shelf.
MIN_SIDES_M = {"bathroom": (2.0, 2.25), "corridor": (1.5, 2.5), "entryway": (1.75, 2.0)}
MIN_SIDES_DEFAULT_M = (1.75, 2.0)
FOLD_CELLS = 56
"""A corridor longer than 14 m is folded into two legs."""
WALL_CELLS = {"doorway": 6, "opening_1.2": 7, "opening_1.5": 8, "opening_2.0": 10, "open": 6}
GAP_CELLS = {"doorway": 4, "opening_1.2": 5, "opening_1.5": 6, "opening_2.0": 8}
N_PLANS = 12
MANY_ROOMS = 12
"""Homes with more rooms draw twice as many plans."""


def lay_out(program: HomeProgram, seed: int, name: str) -> FloorPlan:
    """The best of several seeded floor plans.

    Args:
        program: rooms and edges of the home.
        seed: of the plans.
        name: of the home.
    """
    program = _raise_small_rooms(program)
    best: tuple[float, FloorPlan] | None = None
    enough = N_PLANS * (1 + (len(program.rooms) > MANY_ROOMS))
    for attempt in range(4 * N_PLANS):
        if attempt >= enough and best is not None:
            break
        plan = _grow(program, seed, attempt)
        if plan is None:
            continue
        trim_corridors(plan, program)
        pad(plan, program)
        cost = plan_cost(plan, program)
        if best is None or cost < best[0]:
            best = cost, plan
    plan = best[1] if best else block_plan(program)
    for a, b, joint in plan.edges:
        if shared_wall(plan.rect(a), plan.rect(b)) is None:
            raise SceneError(f"{name}: no wall between {a} and {b} for a {joint}; report this seed")
    return plan


def _raise_small_rooms(program: HomeProgram) -> HomeProgram:
    rooms = []
    for room in program.rooms:
        small, large = sorted(room.size_m)
        least = MIN_SIDES_M.get(room.type, MIN_SIDES_DEFAULT_M)
        rooms.append(replace(room, size_m=(max(small, least[0]), max(large, least[1]))))
    return replace(program, rooms=tuple(rooms))


def _cells(room: RoomProgram) -> tuple[int, int]:
    small, large = sorted(round(side / GRID_M) for side in room.size_m)
    return small, large


def _children(program: HomeProgram) -> dict[str, list[tuple[str, str]]]:
    tree: dict[str, list[tuple[str, str]]] = {room.name: [] for room in program.rooms}
    for parent, child, joint in program.edges:
        tree[parent].append((child, joint))
    return tree


def _grow(program: HomeProgram, seed: int, attempt: int) -> FloorPlan | None:
    rng = stream(seed, "layout", attempt)
    rooms = {room.name: room for room in program.rooms}
    tree = _children(program)
    weight = {name: float(np.prod(_cells(rooms[name]))) * rng.uniform(0.6, 1.4) for name in sorted(rooms)}
    for name in sorted(rooms, key=lambda n: -_depth(program, n)):  # a chain of rooms ranks by the sum of its weights
        weight[name] += sum(weight[child] for child, _ in tree[name] if rooms[child].type != "garden")
    plan = FloorPlan()
    legs: dict[str, list[str]] = {}
    _place_hub(plan, legs, rooms[program.hub], attempt, rng)
    gardens: list[tuple[str, str, str]] = []
    stack = [program.hub]
    while stack:
        parent = stack.pop()
        order = sorted(tree[parent], key=lambda c: -weight[c[0]])
        if rooms[parent].type == "corridor" and rooms[parent].name != program.hub:
            order.reverse()
        for child, joint in order:
            if rooms[child].type == "garden":
                gardens.append((parent, child, joint))
                continue
            if not _attach(plan, legs.get(parent, [parent]), rooms[child], joint, rng, program):
                return None
            # Descend at once so that kitchen-dining-living chains find room before others close in.
            sub = _subtree(child, tree, rooms, gardens)
            for up, down, kind in sub:
                if not _attach(plan, [up], rooms[down], kind, rng, program):
                    return None
    for parent, child, joint in gardens:
        if not _attach(plan, legs.get(parent, [parent]), rooms[child], joint, rng, program):
            return None
    return plan


def _depth(program: HomeProgram, name: str) -> int:
    parent = {child: up for up, child, _ in program.edges}
    depth = 0
    while name in parent:
        name, depth = parent[name], depth + 1
    return depth


def _subtree(
    root: str,
    tree: dict[str, list[tuple[str, str]]],
    rooms: dict[str, RoomProgram],
    gardens: list[tuple[str, str, str]],
) -> list[tuple[str, str, str]]:
    found: list[tuple[str, str, str]] = []
    for child, joint in tree[root]:
        if rooms[child].type == "garden":
            gardens.append((root, child, joint))
        else:
            found.append((root, child, joint))
            found.extend(_subtree(child, tree, rooms, gardens))
    return found


def _place_hub(
    plan: FloorPlan, legs: dict[str, list[str]], hub: RoomProgram, attempt: int, rng: np.random.Generator
) -> None:
    """Put the hub at the origin. A corridor starts longer with every attempt; unused ends are trimmed later."""
    width, length = _cells(hub)
    if hub.type != "corridor":
        plan.add(hub.name, (0, 0, length, width))
        return
    length = int(length * (1.0 + 0.08 * (attempt % N_PLANS) + 0.5 * (attempt // N_PLANS)))
    if length <= FOLD_CELLS and (length < FOLD_CELLS * 0.7 or rng.random() < 0.5):
        plan.add(hub.name, (0, 0, length, width))
        return
    first = round(length * rng.uniform(0.5, 0.62))
    second = length - first
    plan.add(hub.name, (0, 0, first, width))
    start = int(rng.choice([0, first - width, (first - width) // 2]))
    part = f"{hub.name}_b"
    plan.add(part, (start, width, start + width, width + second))
    plan.edges.append((hub.name, part, "open"))
    legs[hub.name] = [hub.name, part]


def _attach(
    plan: FloorPlan,
    parents: Sequence[str],
    room: RoomProgram,
    joint: str,
    rng: np.random.Generator,
    program: HomeProgram,
) -> bool:
    """Place a room at one of its possible parents; False where it fits nowhere."""
    rows, owner = [], []
    placed = np.array(plan.rects)  # (n, 4)
    small, large = _cells(room)
    for index, parent in enumerate(parents):
        for w, h in {(small, large): 0, (large, small): 0}:
            for rect in _flush_places(plan.rect(parent), placed, w, h, WALL_CELLS[joint]):
                rows.append(rect)
                owner.append(index)
    if not rows:
        return False
    rects = np.array(rows)  # (m, 4)
    overlap = (
        (rects[:, None, 0] < placed[None, :, 2])
        & (rects[:, None, 2] > placed[None, :, 0])
        & (rects[:, None, 1] < placed[None, :, 3])
        & (rects[:, None, 3] > placed[None, :, 1])
    ).any(1)
    keep = np.flatnonzero(~overlap)
    if not len(keep):
        return False
    cost = _place_cost(rects[keep], placed) + rng.uniform(0, 6.0, len(keep))
    if program.hub not in parents:  # keep the hub's walls free for its own children
        cost += 0.9 * _contact(rects[keep], placed[:2] if f"{program.hub}_b" in plan.names else placed[:1])
    best = int(keep[int(np.argmin(cost))])
    x0, y0, x1, y1 = (int(v) for v in rects[best])
    plan.add(room.name, (x0, y0, x1, y1))
    plan.edges.append((parents[owner[best]], room.name, joint))
    return True


def _flush_places(parent: Rect, placed: np.ndarray, w: int, h: int, least: int) -> list[Rect]:
    """Places of a w x h room along the four sides of ``parent`` whose edges line up with an existing edge."""
    px0, py0, px1, py1 = parent
    found: list[Rect] = []
    xs = {px0, px1 - w, px0 + least - w, px1 - least} | {
        int(v) for r in placed for v in (r[0] - w, r[2], r[0], r[2] - w)
    }
    ys = {py0, py1 - h, py0 + least - h, py1 - least} | {
        int(v) for r in placed for v in (r[1] - h, r[3], r[1], r[3] - h)
    }
    for x in sorted(xs):
        if min(x + w, px1) - max(x, px0) >= least:
            found += [(x, py1, x + w, py1 + h), (x, py0 - h, x + w, py0)]
    for y in sorted(ys):
        if min(y + h, py1) - max(y, py0) >= least:
            found += [(px1, y, px1 + w, y + h), (px0 - w, y, px0, y + h)]
    return found


def _place_cost(rects: np.ndarray, placed: np.ndarray) -> np.ndarray:
    """Growth of the outline, minus wall shared with rooms already there, plus distance from the middle."""
    low, high = placed[:, :2].min(0), placed[:, 2:].max(0)
    new_low, new_high = np.minimum(rects[:, :2], low), np.maximum(rects[:, 2:], high)
    size = new_high - new_low
    growth = size.prod(1) - (high - low).prod()
    area = (rects[:, 2:] - rects[:, :2]).prod(1)
    contact = _contact(rects, placed)
    ratio = size.max(1) / size.min(1)
    middle = (placed[:, :2].min(0) + placed[:, 2:].max(0)) / 2
    away = np.abs((rects[:, :2] + rects[:, 2:]) / 2 - middle).sum(1)
    return (
        np.clip(growth - area, 0, None) * 0.10
        + growth * 0.02
        - contact * 0.6
        + 6.0 * np.clip(ratio - 1.4, 0, 2)
        + away * 0.15
    )


def _contact(rects: np.ndarray, placed: np.ndarray) -> np.ndarray:
    """Length of wall that each of ``rects`` (m, 4) shares with ``placed`` (n, 4), (m,) cells."""
    contact = np.zeros(len(rects))
    for axis in (0, 1):
        other = 1 - axis
        touch = (rects[:, None, axis] == placed[None, :, 2 + axis]) | (
            rects[:, None, 2 + axis] == placed[None, :, axis]
        )
        low = np.maximum(rects[:, None, other], placed[None, :, other])
        high = np.minimum(rects[:, None, 2 + other], placed[None, :, 2 + other])
        contact += (touch * np.clip(high - low, 0, None)).sum(1)
    return contact


def block_plan(program: HomeProgram) -> FloorPlan:
    """A simple plan that always exists: every room spans its children, which are side by side below it."""
    program = _raise_small_rooms(program)
    rooms = {room.name: room for room in program.rooms}
    tree = _children(program)
    plan = FloorPlan()

    def width(name: str) -> int:
        return max(_cells(rooms[name])[0], sum(width(child) for child, _ in tree[name]), 8)

    def put(name: str, x: int, y: int) -> None:
        small, large = _cells(rooms[name])
        w = max(small, sum(max(width(child), WALL_CELLS[joint] + 2) for child, joint in tree[name]), 8)
        h = small if rooms[name].type == "corridor" else max(large, 7)
        plan.add(name, (x, y, x + w, y + h))
        at = x
        for child, joint in tree[name]:
            put(child, at, y + h)
            plan.edges.append((name, child, joint))
            at += max(width(child), WALL_CELLS[joint] + 2)

    put(program.hub, 0, 0)
    return plan
