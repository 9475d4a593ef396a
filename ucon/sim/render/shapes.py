"""The convex unit shapes that all parts are made of, as one set of tables.

Corners are in a unit cube around the origin; the corners of a face run counter-clockwise seen from outside. Which
corners make which face depends on the shape alone, so all faces of a home refer to the one index table here.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.objects.model import Part

Faces = tuple[tuple[int, ...], ...]
Solid = tuple[NDArray[np.float64], Faces]

BOTTOM, TOP = 0, 1
"""The only face of a box that is drawn for a floor (TOP) or a ceiling (BOTTOM)."""


def _box() -> Solid:
    corners = np.array([[x, y, z] for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)])
    return corners, ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))


def _wedge() -> Solid:
    """Ramp that rises along x: a level bottom, an upright back at +x, a slope and two triangles."""
    low = [[x, y, -0.5] for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
    corners = np.array([*low, [0.5, -0.5, 0.5], [0.5, 0.5, 0.5]])
    return corners, ((0, 2, 3, 1), (1, 3, 5, 4), (0, 4, 5, 2), (0, 1, 4), (2, 5, 3))


def _prism(sides: int) -> Solid:
    angle = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    ring = 0.5 * np.stack([np.cos(angle), np.sin(angle)], 1)
    corners = np.concatenate([np.insert(ring, 2, z, axis=1) for z in (-0.5, 0.5)])
    walls = tuple((i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides))
    return corners, (tuple(range(sides - 1, -1, -1)), tuple(range(sides, 2 * sides)), *walls)


def _ball(around: int, bands: int) -> Solid:
    """The quads between two level circles are flat, also when the ball is stretched."""
    corners = [[0.0, 0.0, -0.5]]
    for k in range(1, bands):
        tilt = -np.pi / 2 + np.pi * k / bands
        for i in range(around):
            turn = 2 * np.pi * i / around
            corners.append([0.5 * np.cos(tilt) * np.cos(turn), 0.5 * np.cos(tilt) * np.sin(turn), 0.5 * np.sin(tilt)])
    corners.append([0.0, 0.0, 0.5])
    last, start = len(corners) - 1, 1 + (bands - 2) * around
    faces: list[tuple[int, ...]] = []
    for i in range(around):
        j = (i + 1) % around
        rings = [1 + k * around for k in range(bands - 2)]
        faces.append((0, 1 + j, 1 + i))
        faces += [(a + i, a + j, a + around + j, a + around + i) for a in rings]
        faces.append((start + i, start + j, last))
    return np.array(corners), tuple(faces)


_SOLIDS = (_box(), _wedge(), _prism(6), _prism(8), _prism(12), _ball(6, 3), _ball(8, 4), _ball(10, 6))


def _tables() -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int16], NDArray[np.int16]]:
    corners = np.concatenate([solid[0] for solid in _SOLIDS])
    solids: list[tuple[int, ...]] = []
    faces: list[tuple[int, int]] = []
    index: list[int] = []
    first_vertex = 0
    for vertices, polygons in _SOLIDS:
        solids.append((first_vertex, len(vertices), len(faces), len(polygons)))
        first_vertex += len(vertices)
        for polygon in polygons:
            faces.append((len(index), len(polygon)))
            index.extend(polygon)
    return corners, np.array(solids, np.int32), np.array(faces, np.int16), np.array(index, np.int16)


CORNERS, SOLIDS, FACES, INDEX = _tables()
"""Corners (n, 3); per solid: first corner, corners, first face, faces; per face: start in INDEX, corners; INDEX."""

MOST_CORNERS = int(SOLIDS[:, 1].max())
MOST_FACES = int(SOLIDS[:, 3].max())
MOST_SIDES = int(FACES[:, 1].max())


def solid_of(part: Part) -> int:
    """Row of SOLIDS for a part; large round parts have more sides."""
    if part.shape == "box":
        return 0
    if part.shape == "wedge":
        return 1
    if part.shape == "cylinder":
        radius = max(part.size[0], part.size[1]) / 2
        return 2 if radius < 0.02 else 3 if radius < 0.06 else 4
    largest = max(part.size)
    return 5 if largest < 0.05 else 6 if largest < 0.15 else 7
