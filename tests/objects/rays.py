"""Rays against a model's convex parts, with the flat sides of the renderer: a second opinion on what can be seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import axis_angle_matrix, matrix_from_rpy
from ucon.objects.model import ObjectModel, Part

Array = NDArray[np.float64]
SIDES = 12


def planes(part: Part) -> tuple[Array, Array]:
    """Half-spaces n.p <= d of a part in its own frame: normals (k, 3) and offsets (k,)."""
    sx, sy, sz = (s / 2 for s in part.size)
    cap = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    if part.shape == "box":
        return np.vstack([np.eye(3), -np.eye(3)]), np.array([sx, sy, sz, sx, sy, sz])
    if part.shape == "wedge":
        slope = np.array([-sz, 0.0, sx]) / np.hypot(sx, sz)
        normals = np.vstack([slope, [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, -1]])
        return normals, np.array([0.0, sx, sy, sy, sz])
    if part.shape == "cylinder":
        angles = 2 * np.pi * (np.arange(SIDES) + 0.5) / SIDES
        rim = np.stack([sx * np.cos(angles), sy * np.sin(angles)], 1)
        after = np.roll(rim, -1, 0)
        outward = np.stack([after[:, 1] - rim[:, 1], rim[:, 0] - after[:, 0]], 1)
        reach = (outward * rim).sum(1)  # n.p on the bottom edge
        drop = reach * (1 - part.taper) / (2 * sz)
        normals = np.column_stack([outward, drop])
        offsets = reach + drop * -sz
        length = np.linalg.norm(normals, axis=1)
        return np.vstack([normals / length[:, None], cap]), np.append(offsets / length, [sz, sz])
    turns = np.arange(8) * np.pi / 4
    rows = [(np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)) for b in (-0.9, 0.0, 0.9) for a in turns]
    unit = np.array([*rows, (0, 0, 1), (0, 0, -1)])
    normals = unit / np.array([sx, sy, sz])
    length = np.linalg.norm(normals, axis=1)
    return normals / length[:, None], np.full(len(unit), 0.97) / length


def pose(model: ObjectModel, link: int, opening: float) -> tuple[Array, Array]:
    """Rotation and translation of the parts that a joint carries, at ``opening`` 0..1."""
    if link < 0 or opening == 0.0:
        return np.eye(3), np.zeros(3)
    joint = model.joints[link]
    if joint.kind == "prismatic":
        return np.eye(3), np.array(joint.axis) * joint.travel * opening
    turn = axis_angle_matrix(np.array(joint.axis, float), joint.travel * opening)
    origin = np.array(joint.origin)
    return turn, origin - turn @ origin


def cast(
    model: ObjectModel, origins: Array, directions: Array, opening: float = 0.0
) -> tuple[Array, NDArray[np.intp], Array]:
    """First hits of rays (n, 3): distance in units of the direction (inf: none), part number (-1), normal (n, 3)."""
    count = len(origins)
    best, which, normal = np.full(count, np.inf), np.full(count, -1), np.zeros((count, 3))
    for number, part in enumerate(model.parts):
        turn, shift = pose(model, part.link, opening)
        rotation = turn @ matrix_from_rpy(part.rpy_rad)
        center = turn @ np.array(part.center) + shift
        normals, offsets = planes(part)
        o, d = (origins - center) @ rotation, directions @ rotation
        rate, gap = d @ normals.T, offsets - o @ normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            t = gap / rate
        enter = np.where(rate < 0, t, -np.inf)
        leave = np.where(rate > 0, t, np.inf)
        outside = ((rate == 0) & (gap < 0)).any(1)
        first, last = enter.max(1), leave.min(1)
        hit = (first <= last) & (last > 0) & ~outside & (first > 1e-9) & (first < best)
        best[hit], which[hit] = first[hit], number
        normal[hit] = normals[enter[hit].argmax(1)] @ rotation.T
    return best, which, normal
