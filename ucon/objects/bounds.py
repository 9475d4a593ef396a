"""Exact axis-aligned boxes of parts, and stretching of parts to a given size. Plain Python, since parts are few."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import cos, hypot, sin, sqrt

from ucon.objects.model import Box3, Part, Vec3

Rows = tuple[Vec3, Vec3, Vec3]
_UPRIGHT: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def rotation_rows(rpy_rad: Vec3) -> Rows:
    """Rotation matrix of roll, pitch, yaw in radians about fixed axes, as three rows."""
    if rpy_rad == (0.0, 0.0, 0.0):
        return _UPRIGHT
    roll, pitch, yaw = rpy_rad
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def part_box(part: Part) -> Box3:
    """The smallest axis-aligned box around a part in the object frame, metres."""
    sx, sy, sz = (0.5 * s for s in part.size)
    low, high = [], []
    for axis, (a, b, c) in enumerate(rotation_rows(part.rpy_rad)):
        if part.shape == "box":
            up = abs(a) * sx + abs(b) * sy + abs(c) * sz
            down = -up
        elif part.shape == "sphere":
            up = sqrt((a * sx) ** 2 + (b * sy) ** 2 + (c * sz) ** 2)
            down = -up
        elif part.shape == "cylinder":
            rim = hypot(a * sx, b * sy)
            top = part.taper * rim
            up = max(c * sz + top, -c * sz + rim)
            down = min(c * sz - top, -c * sz - rim)
        else:
            corners = [a * x + c * z for x, z in ((-sx, -sz), (sx, -sz), (sx, sz))]
            up = max(corners) + abs(b) * sy
            down = min(corners) - abs(b) * sy
        low.append(part.center[axis] + down)
        high.append(part.center[axis] + up)
    return (low[0], low[1], low[2], high[0], high[1], high[2])


def union_box(boxes: Iterable[Box3]) -> Box3:
    """The smallest box around one or more boxes."""
    columns = list(zip(*boxes, strict=True))
    return (
        min(columns[0]),
        min(columns[1]),
        min(columns[2]),
        max(columns[3]),
        max(columns[4]),
        max(columns[5]),
    )


def fit(parts: list[Part], size: Vec3, rounds: int = 4) -> list[Part]:
    """Stretch parts so that together they have a given size, centred on the origin with the bottom at z = 0.

    Upright parts are stretched exactly. Turned ones keep their right angles, so a few rounds are needed; a last uniform
    shrink makes sure that nothing sticks out.

    Args:
        parts: of one object.
        size: wanted extent, metres.
        rounds: most rounds.
    """
    for _ in range(rounds):
        box = union_box(map(part_box, parts))
        scale = tuple(s / max(hi - lo, 1e-9) for s, lo, hi in zip(size, box[:3], box[3:], strict=True))
        if all(abs(f - 1.0) < 1e-6 for f in scale) and abs(box[2]) < 1e-9:
            break
        parts = [_stretched(part, scale, box) for part in parts]
    box = union_box(map(part_box, parts))
    excess = max((hi - lo) / s for s, lo, hi in zip(size, box[:3], box[3:], strict=True))
    shrink = min(1.0, 1.0 / excess)
    return [_stretched(part, (shrink, shrink, shrink), box) for part in parts]


def _stretched(part: Part, scale: tuple[float, ...], box: Box3) -> Part:
    middle = ((box[0] + box[3]) / 2, (box[1] + box[4]) / 2, box[2])
    center = tuple((c - m) * f for c, m, f in zip(part.center, middle, scale, strict=True))
    if part.rpy_rad == (0.0, 0.0, 0.0):
        factors: tuple[float, ...] = scale
    else:
        rows = rotation_rows(part.rpy_rad)
        columns = zip(*rows, strict=True)
        factors = tuple(sqrt(sum((f * v) ** 2 for f, v in zip(scale, column, strict=True))) for column in columns)
    size = tuple(s * f for s, f in zip(part.size, factors, strict=True))
    return replace(part, size=(size[0], size[1], size[2]), center=(center[0], center[1], center[2]))
