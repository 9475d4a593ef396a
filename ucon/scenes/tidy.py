"""A floor plan on the grid, and its clean-up once all rooms are placed: trimming, padding, cost."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ucon.scenes.program import HomeProgram

Rect = tuple[int, int, int, int]
"""x0, y0, x1, y1 in cells."""

WALK_CELLS = 130
"""Plans with longer walks than this (32.5 m) cost more."""


@dataclass
class FloorPlan:
    """The placed rooms of a home.

    Attributes:
        names: of the rooms.
        rects: x0, y0, x1, y1 of each in cells.
        edges: (room, room, kind of opening).
    """

    names: list[str] = field(default_factory=list)
    rects: list[Rect] = field(default_factory=list)
    edges: list[tuple[str, str, str]] = field(default_factory=list)

    def rect(self, name: str) -> Rect:
        """Rectangle of a room, by name."""
        return self.rects[self.names.index(name)]

    def add(self, name: str, rect: Rect) -> None:
        """Append a room."""
        self.names.append(name)
        self.rects.append(rect)


def shared_wall(a: Rect, b: Rect) -> tuple[int, int, int, int] | None:
    """The wall that two rooms share.

    Returns:
        (axis, coordinate, lo, hi) in cells; None if there is none.
    """
    for axis in (0, 1):
        lo = max(a[1 - axis], b[1 - axis])
        hi = min(a[3 - axis], b[3 - axis])
        if hi > lo:
            if a[2 + axis] == b[axis]:
                return axis, b[axis], lo, hi
            if b[2 + axis] == a[axis]:
                return axis, a[axis], lo, hi
    return None


def _needed(plan: FloorPlan, index: int) -> list[tuple[int, int, int]]:
    """(axis, lo, hi) of the wall that the openings of a room need."""
    name = plan.names[index]
    found = []
    for a, b, _joint in plan.edges:
        if name in (a, b):
            wall = shared_wall(plan.rect(a), plan.rect(b))
            if wall:
                found.append((wall[0], wall[2], wall[3]))
    return found


def trim_corridors(plan: FloorPlan, program: HomeProgram) -> None:
    """Cut off the ends of corridors that lead nowhere."""
    types = {room.name: room.type for room in program.rooms}
    for index, name in enumerate(plan.names):
        if types.get(name.removesuffix("_b"), "") != "corridor":
            continue
        rect = list(plan.rects[index])
        axis = 0 if rect[2] - rect[0] >= rect[3] - rect[1] else 1
        spans = []
        for along, lo, hi in _needed(plan, index):
            if along == 1 - axis:  # a room at a long side
                spans.append((lo, hi))
            else:  # a room at an end keeps that end
                end = rect[axis], rect[2 + axis]
                walls = [shared_wall(plan.rect(a), plan.rect(b)) for a, b, _ in plan.edges if name in (a, b)]
                spans += [(w[1], w[1]) for w in walls if w and w[0] == axis and w[1] in end]
        lo, hi = min(s[0] for s in spans), max(s[1] for s in spans)
        if hi - lo >= 8:
            rect[axis], rect[2 + axis] = lo, hi
            plan.rects[index] = (rect[0], rect[1], rect[2], rect[3])


def pad(plan: FloorPlan, program: HomeProgram) -> None:
    """Move walls out by up to 1 m where that closes a gap to another room or to the outline."""
    types = {room.name: room.type for room in program.rooms}
    kept = {room.name for room in program.rooms if room.exact}
    for reach in (2, 4):
        for index in sorted(range(len(plan.names)), key=lambda i: _area(plan.rects[i])):
            kind = types.get(plan.names[index].removesuffix("_b"), "")
            if kind in ("garden", "corridor") or plan.names[index] in kept:
                continue
            for side in range(4):
                _push(plan, index, side, reach)


def _area(rect: Rect) -> int:
    return (rect[2] - rect[0]) * (rect[3] - rect[1])


def _push(plan: FloorPlan, index: int, side: int, reach: int) -> None:
    rect = plan.rects[index]
    axis, forward = side % 2, side >= 2
    others = [r for i, r in enumerate(plan.rects) if i != index]
    edge = max(r[side] for r in plan.rects) if forward else min(r[side] for r in plan.rects)
    targets = [edge] + [r[axis] if forward else r[2 + axis] for r in others]
    limit = min(reach, max(2, (rect[2 + axis] - rect[axis]) // 4))
    gaps = sorted({(t - rect[side]) if forward else (rect[side] - t) for t in targets})
    for gap in gaps:
        if not 0 < gap <= limit:
            continue
        grown = list(rect)
        grown[side] += gap if forward else -gap
        clash = any(grown[0] < r[2] and grown[2] > r[0] and grown[1] < r[3] and grown[3] > r[1] for r in others)
        touches = any(
            (r[axis] if forward else r[2 + axis]) == grown[side]
            and min(grown[3 - axis], r[3 - axis]) > max(grown[1 - axis], r[1 - axis])
            for r in others
        )
        if not clash and (touches or grown[side] == edge):
            plan.rects[index] = (grown[0], grown[1], grown[2], grown[3])
            return


def plan_cost(plan: FloorPlan, program: HomeProgram) -> float:
    """Cost of a plan, lower is better: outline, gaps, corridor length, elongated outlines."""
    rects = np.array(plan.rects)
    size = rects[:, 2:].max(0) - rects[:, :2].min(0)
    used = float((rects[:, 2:] - rects[:, :2]).prod(1).sum())
    outline = float(size.prod())
    ratio = float(size.max() / size.min())
    reach = longest_walk(plan)
    return (outline - used) * 1.0 + 0.2 * outline + 60.0 * max(0.0, ratio - 1.6) + 12.0 * max(0.0, reach - WALK_CELLS)


def longest_walk(plan: FloorPlan) -> float:
    """Longest of the shortest walks between room corners through the openings, in cells; furniture is ignored."""
    doors: dict[str, list[int]] = {name: [] for name in plan.names}
    points: list[tuple[float, float]] = []
    for a, b, _ in plan.edges:
        wall = shared_wall(plan.rect(a), plan.rect(b))
        if wall is not None:
            middle = (wall[2] + wall[3]) / 2
            doors[a].append(len(points))
            doors[b].append(len(points))
            points.append((wall[1], middle) if wall[0] == 0 else (middle, wall[1]))
    if not points:  # a single room
        return 0.0
    xy = np.array(points)  # (m, 2)
    walk = np.full((len(points), len(points)), np.inf)
    for members in doors.values():
        part = xy[members]
        walk[np.ix_(members, members)] = np.abs(part[:, None] - part[None]).sum(-1)
    for k in range(len(points)):
        walk = np.minimum(walk, walk[:, k, None] + walk[None, k])
    reach = np.zeros(len(points))  # from each opening to the far corner of the rooms it leads to
    for name, members in doors.items():
        x0, y0, x1, y1 = plan.rect(name)
        for k in members:
            far = max(xy[k, 0] - x0, x1 - xy[k, 0]) + max(xy[k, 1] - y0, y1 - xy[k, 1])
            reach[k] = max(reach[k], far)
    return float((walk + reach[:, None] + reach[None]).max())
