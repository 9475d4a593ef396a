"""Independent checks of a home, written from the specification and not from the generator's code."""

from __future__ import annotations

import numpy as np

from ucon.objects.models import build_model
from ucon.scenes.spec import GRID_M, HomeSpec, Item

CLEARANCE_M = 0.18
OVERLAP_M = 0.005


def box_of(item: Item) -> np.ndarray:
    sx, sy = item.size[:2] if item.quarter_turns % 2 == 0 else (item.size[1], item.size[0])
    x, y, z = item.position
    return np.array([x - sx / 2, y - sy / 2, z, x + sx / 2, y + sy / 2, z + item.size[2]])


def part_boxes(item: Item) -> np.ndarray:
    """World boxes (n, 6) of an item's axis-aligned parts, all joints closed; turned parts are left out."""
    rows = []
    for part in build_model(item.category, item.size, item.tint).parts:
        if any(abs(a) > 1e-9 for a in part.rpy_rad):
            continue
        lo = [c - s / 2 for c, s in zip(part.center, part.size, strict=True)]
        hi = [c + s / 2 for c, s in zip(part.center, part.size, strict=True)]
        corners = []
        for x, y in ((lo[0], lo[1]), (hi[0], hi[1])):
            for _ in range(item.quarter_turns % 4):
                x, y = -y, x
            corners.append((x + item.position[0], y + item.position[1]))
        (ax, ay), (bx, by) = corners
        z = item.position[2]
        rows.append((min(ax, bx), min(ay, by), lo[2] + z, max(ax, bx), max(ay, by), hi[2] + z))
    return np.array(rows).reshape(-1, 6)


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    """Depth in metres to which two boxes interpenetrate, 0 if they do not."""
    return float(max(0.0, (np.minimum(a[3:], b[3:]) - np.maximum(a[:3], b[:3])).min()))


def walls_of(spec: HomeSpec) -> list[np.ndarray]:
    """Wall boxes (0.10 m thick, split at openings) around every room."""
    found = []
    for index, room in enumerate(spec.rooms):
        x0, y0, x1, y1 = room.rect
        for axis, coord, lo, hi in ((0, x0, y0, y1), (0, x1, y0, y1), (1, y0, x0, x1), (1, y1, x0, x1)):
            holes = sorted(
                (o.lo, o.hi)
                for o in spec.openings
                if o.axis == axis and abs(o.coord - coord) < 1e-9 and index in (o.room_a, o.room_b)
            )
            at = lo
            for a, b in [*holes, (hi, hi)]:
                if a > at:
                    span = (coord - 0.05, at, coord + 0.05, a) if axis == 0 else (at, coord - 0.05, a, coord + 0.05)
                    found.append(np.array([span[0], span[1], 0.0, span[2], span[3], spec.wall_height_m]))
                at = max(at, b)
    return found


def nav_grid(spec: HomeSpec) -> tuple[np.ndarray, np.ndarray]:
    """(free (nx, ny) bool, room (nx, ny) int) from exact distances to boxes; doors count part by part."""
    rects = np.array([r.rect for r in spec.rooms])
    low = rects[:, :2].min(0)
    n = np.round((rects[:, 2:].max(0) - low) / GRID_M).astype(int)
    xs = low[0] + (np.arange(n[0]) + 0.5) * GRID_M
    ys = low[1] + (np.arange(n[1]) + 0.5) * GRID_M
    room = np.full(n, -1)
    for index, r in enumerate(rects):
        inside = np.ix_((xs > r[0]) & (xs < r[2]), (ys > r[1]) & (ys < r[3]))
        room[inside] = index
    boxes = walls_of(spec)
    for item in spec.items:
        boxes.extend(part_boxes(item) if item.category == "door" else [box_of(item)])
    free = room >= 0
    for b in boxes:
        if b[2] >= 1.8 or b[5] <= 0.05:
            continue
        dx = np.maximum(np.maximum(b[0] - xs, xs - b[3]), 0.0)
        dy = np.maximum(np.maximum(b[1] - ys, ys - b[4]), 0.0)
        free &= ~((dx[:, None] ** 2 + dy[None, :] ** 2) < CLEARANCE_M**2 - 1e-9)
    return free, room


def components(free: np.ndarray) -> np.ndarray:
    """Labels of 4-connected components, 0 where not free."""
    label = np.zeros(free.shape, int)
    count = 0
    for start in zip(*np.nonzero(free), strict=True):
        if label[start]:
            continue
        count += 1
        stack = [start]
        label[start] = count
        while stack:
            i, j = stack.pop()
            for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                if 0 <= a < free.shape[0] and 0 <= b < free.shape[1] and free[a, b] and not label[a, b]:
                    label[a, b] = count
                    stack.append((a, b))
    return label


def problems(spec: HomeSpec) -> list[str]:
    """Everything that is wrong with a home, as one line each."""
    return [
        *room_problems(spec),
        *opening_problems(spec),
        *item_problems(spec),
        *window_problems(spec),
        *walk_problems(spec),
    ]


def room_problems(spec: HomeSpec) -> list[str]:
    found = []
    rects = [np.array(r.rect) for r in spec.rooms]
    if len({r.name for r in spec.rooms}) != len(spec.rooms):
        found.append("two rooms share a name")
    for i, a in enumerate(rects):
        if np.abs(a / GRID_M - np.round(a / GRID_M)).max() > 1e-9:
            found.append(f"{spec.rooms[i].name}: off the grid {a}")
        for j in range(i):
            b = rects[j]
            if (np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]) > 1e-9).all():
                found.append(f"{spec.rooms[i].name} overlaps {spec.rooms[j].name}")
    return found


def opening_problems(spec: HomeSpec) -> list[str]:
    found = []
    for o in spec.openings:
        names = f"{spec.rooms[o.room_a].name}-{spec.rooms[o.room_b].name}"
        sides = set()
        for index in (o.room_a, o.room_b):
            r = spec.rooms[index].rect
            if o.coord not in (r[o.axis], r[2 + o.axis]):
                found.append(f"{names}: not in a wall")
            sides.add(o.coord == r[o.axis])
            if o.lo < r[1 - o.axis] - 1e-9 or o.hi > r[3 - o.axis] + 1e-9:
                found.append(f"{names}: wider than the shared wall")
        if sides != {True, False}:
            found.append(f"{names}: both rooms on one side")
        if o.hi - o.lo < 1.0 - 1e-9:
            found.append(f"{names}: {o.hi - o.lo} m wide")
        if (o.lo / GRID_M) % 1 or (o.hi / GRID_M) % 1:
            found.append(f"{names}: off the grid")
    return found


def item_problems(spec: HomeSpec) -> list[str]:
    found = []
    boxes = [box_of(i) for i in spec.items]
    for item, box in zip(spec.items, boxes, strict=True):
        if item.category == "door":
            continue
        r = spec.rooms[item.room].rect
        if (box[:2] < np.array(r[:2]) + 0.05 - 1e-3).any() or (box[3:5] > np.array(r[2:]) - 0.05 + 1e-3).any():
            found.append(f"{item.category} at {item.position} reaches out of {spec.rooms[item.room].name}")
        if box[5] > spec.wall_height_m + 1e-6 and not spec.rooms[item.room].outdoor:
            found.append(f"{item.category} is taller than the room")
    by_room: dict[int, list[int]] = {}
    for k, item in enumerate(spec.items):
        by_room.setdefault(item.room, []).append(k)
    for members in by_room.values():
        for n, i in enumerate(members):
            found += [
                f"{spec.items[i].category} in {spec.items[j].category} at {spec.items[i].position}"
                for j in members[:n]
                if overlap(boxes[i], boxes[j]) > OVERLAP_M and _parts_meet(spec.items[i], spec.items[j])
            ]
    return found


def _parts_meet(a: Item, b: Item) -> bool:
    return any(overlap(p, q) > OVERLAP_M for p in part_boxes(a) for q in part_boxes(b))


def window_problems(spec: HomeSpec) -> list[str]:
    found = []
    for item in spec.items:
        if item.category != "window":
            continue
        room = spec.rooms[item.room].rect
        axis = item.quarter_turns % 2
        low = item.quarter_turns < 2
        wall = room[axis] if low else room[2 + axis]
        at, half = item.position[1 - axis], item.size[1] / 2
        for other in spec.rooms:
            edge = other.rect[2 + axis] if low else other.rect[axis]
            if edge == wall and other.rect[1 - axis] < at + half and other.rect[3 - axis] > at - half:
                found.append(f"window of {spec.rooms[item.room].name} looks into {other.name}")
        if any(o.axis == axis and o.coord == wall and o.lo < at + half and o.hi > at - half for o in spec.openings):
            found.append(f"window of {spec.rooms[item.room].name} in an opening")
    return found


def walk_problems(spec: HomeSpec) -> list[str]:
    free, room = nav_grid(spec)
    label = components(free)
    sizes = np.bincount(label[free])
    if not free.any():
        return ["nowhere to walk"]
    main = int(sizes.argmax())
    found = []
    if sizes[main] < 0.99 * free.sum():
        found.append(f"only {sizes[main]} of {free.sum()} nodes in one piece")
    for index, r in enumerate(spec.rooms):
        n = int(((room == index) & (label == main)).sum())
        if n < 5:
            found.append(f"{r.name}: {n} nodes")
    rects = np.array([r.rect for r in spec.rooms])
    low = rects[:, :2].min(0)
    nodes = (np.argwhere(label == main) + 0.5) * GRID_M + low
    for item in spec.items:
        if item.category in ("door", "window") or not build_model(item.category, item.size).openable:
            continue
        b = box_of(item)
        away = np.maximum(np.maximum(b[[0, 1]] - nodes, nodes - b[[3, 4]]), 0.0)
        near = np.hypot(away[:, 0], away[:, 1]) <= 1.0
        turn = item.quarter_turns
        ahead = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][turn])
        before = (nodes - np.array(item.position[:2])) @ ahead > item.size[0] / 2
        if not (near & before).any():
            found.append(f"{item.category} of {spec.rooms[item.room].name}: nobody can stand before it")
    return found
