"""How far a point is from the nearest footprint, and how far a disc gets along a line. Compiled."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from ucon.core.jit import F64, I32, jit

#: Distances are exact up to this value, which is returned for all larger ones, metres.
HORIZON_M: Final = 0.6
#: Side of the cells that footprints are sorted into.
BUCKET_M: Final = 0.5
#: Distances that differ by no more than this count as equal, so that a disc slides along what it touches, metres.
TOUCH_M: Final = 1e-9
#: Step between two distance checks where the gap to the nearest thing is smaller than this, metres.
_CREEP_M: Final = 1e-3
_HALVINGS: Final = 16


class FloorTables(NamedTuple):
    """Footprints as the kernels take them."""

    points: F64
    """(p, 2) corners of all polygons, one after the other."""
    first: I32
    """(m + 1,) where the corners of each begin."""
    rounding: F64
    """(m,) metres by which each is larger than its polygon."""
    boxes: F64
    """(m, 4) x0 y0 x1 y1 around each."""
    origin: F64
    """(2,) corner of bucket (0, 0), world metres."""
    bucket: I32
    """(nx, ny) number of each bucket's first entry in ``member``; the last one ends at ``len(member)``."""
    ends: I32
    """(nx, ny) where its entries end."""
    member: I32
    """Footprints by bucket: those within ``HORIZON_M``."""


@jit
def polygon_distance(x: float, y: float, points: F64, first: int, end: int) -> float:
    """Distance from a point to a convex polygon; inside it, minus the distance to its border.

    Args:
        x: of the point.
        y: of the point.
        points: (p, 2) corners, counter-clockwise.
        first: its first corner.
        end: after its last one.
    """
    nearest = math.inf
    inside = end - first > 2
    turned = 0
    for k in range(first, end):
        n = k + 1 if k + 1 < end else first
        ax, ay = points[k, 0], points[k, 1]
        ex, ey = points[n, 0] - ax, points[n, 1] - ay
        px, py = x - ax, y - ay
        length = ex * ex + ey * ey
        t = 0.0 if length == 0.0 else min(max((px * ex + py * ey) / length, 0.0), 1.0)
        nearest = min(nearest, math.hypot(px - t * ex, py - t * ey))
        side = ex * py - ey * px
        if side != 0.0:
            sign = 1 if side > 0.0 else -1
            inside = inside and turned in (0, sign)
            turned = sign
    return -nearest if inside else nearest


@jit
def clearance(x: float, y: float, floor: FloorTables) -> float:
    """Distance from a point to the nearest footprint, at most ``HORIZON_M``; negative within one; metres."""
    i, j = int((x - floor.origin[0]) // BUCKET_M), int((y - floor.origin[1]) // BUCKET_M)
    if i < 0 or j < 0 or i >= floor.bucket.shape[0] or j >= floor.bucket.shape[1]:
        return HORIZON_M
    nearest = HORIZON_M
    for entry in range(floor.bucket[i, j], floor.ends[i, j]):
        k = floor.member[entry]
        gap_x = max(floor.boxes[k, 0] - x, x - floor.boxes[k, 2])
        gap_y = max(floor.boxes[k, 1] - y, y - floor.boxes[k, 3])
        if gap_x < nearest and gap_y < nearest:
            polygon = polygon_distance(x, y, floor.points, floor.first[k], floor.first[k + 1])
            nearest = min(nearest, polygon - floor.rounding[k])
    return nearest


@jit
def free_way(x: float, y: float, dx: float, dy: float, radius: float, floor: FloorTables) -> float:
    """How far a disc gets along a line before it touches something.

    A disc that touches something may always move away from it, and slide along it.

    Args:
        x: of the disc's centre, world metres.
        y: of the centre.
        dx: the line, metres.
        dy: the line.
        radius: of the disc, below ``HORIZON_M``.
        floor: the footprints.

    Returns:
        Metres, at most the length of the line.
    """
    length = math.hypot(dx, dy)
    if length == 0.0:
        return 0.0
    ux, uy = dx / length, dy / length
    gone, here = 0.0, clearance(x, y, floor)
    while gone < length:
        step = min(max(here - radius, _CREEP_M), length - gone)
        there = clearance(x + (gone + step) * ux, y + (gone + step) * uy, floor)
        if there < radius - TOUCH_M and there < here - TOUCH_M:
            good, bad = gone, gone + step
            for _ in range(_HALVINGS):
                middle = 0.5 * (good + bad)
                between = clearance(x + middle * ux, y + middle * uy, floor)
                if between < radius - TOUCH_M and between < here - TOUCH_M:
                    bad = middle
                else:
                    good = middle
            return good
        gone += step
        here = there
    return length


@jit
def fill_buckets(boxes: F64, counts: I32, member: I32, origin: F64) -> None:
    """Sort footprints into buckets: called once with an empty ``member`` to count, then to fill it.

    Args:
        boxes: (m, 4) x0 y0 x1 y1 of each, already grown by the horizon.
        counts: (nx, ny) in: where each bucket's entries begin; out: where they end.
        member: entries; empty: only count.
        origin: (2,) corner of bucket (0, 0).
    """
    nx, ny = counts.shape
    for k in range(len(boxes)):
        i0 = max(int((boxes[k, 0] - origin[0]) // BUCKET_M), 0)
        j0 = max(int((boxes[k, 1] - origin[1]) // BUCKET_M), 0)
        i1 = min(int((boxes[k, 2] - origin[0]) // BUCKET_M), nx - 1)
        j1 = min(int((boxes[k, 3] - origin[1]) // BUCKET_M), ny - 1)
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                if len(member):
                    member[counts[i, j]] = k
                counts[i, j] += 1
