"""From parts to convex polygons: a :class:`Mesh` holds the polygons of one model in its own frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import F64, I16, I32, jit
from ucon.objects.model import Material, ObjectModel, Part
from ucon.sim.render.shapes import CORNERS, FACES, INDEX, SOLIDS, solid_of

#: Looks beyond the materials, for the renderer only.
WALL, CEILING, WINDOW, MIRROR = (len(Material) + k for k in range(4))

_LEAST_TAPER = 0.02
"""Cones keep a tiny top, so that their sides are quads."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Polygons of one model with all joints closed: nv corners, np parts, nf faces."""

    vertices: NDArray[np.float64]  # (nv, 3)
    parts: NDArray[np.int32]
    """(np, 5): first vertex, vertices, first face, faces, link."""
    normals: NDArray[np.float64]  # (nf, 3)
    topology: NDArray[np.int16]
    """(nf, 2): first entry in the index table, corners."""
    colors: NDArray[np.float64]
    """(nf, 3), 0 to 255, unlit."""
    looks: NDArray[np.int16]
    """(nf,) material, or one of the looks above."""
    grain: NDArray[np.float64]
    """(nf, 3) direction of wood grain: the longest side of the part."""


def mesh_of_model(model: ObjectModel) -> Mesh:
    """Polygons of a model."""
    return mesh_of_parts(model.parts, [_look(model.category, part.material) for part in model.parts])


def mesh_of_parts(parts: Sequence[Part], looks: Sequence[int], only_face: int = -1) -> Mesh:
    """Polygons of some parts.

    Args:
        parts: the parts.
        looks: material or look of each.
        only_face: keep only this face of each box; -1 keeps all.
    """
    figures = np.array([(*p.size, *p.center, *p.rpy_rad, _taper(p)) for p in parts], np.float64)
    solids = SOLIDS[[solid_of(p) for p in parts]].astype(np.int32).reshape(-1, 4)
    if only_face >= 0:
        solids[:, 2] += only_face
        solids[:, 3] = 1
    table = np.empty((len(parts), 5), np.int32)
    table[:, 1], table[:, 3] = solids[:, 1], solids[:, 3]
    table[:, 0] = np.cumsum(solids[:, 1]) - solids[:, 1]
    table[:, 2] = np.cumsum(solids[:, 3]) - solids[:, 3]
    table[:, 4] = [p.link for p in parts]
    nv, nf = int(solids[:, 1].sum()), int(solids[:, 3].sum())
    vertices, normals, grain = np.empty((nv, 3)), np.empty((nf, 3)), np.empty((nf, 3))
    topology = np.empty((nf, 2), np.int16)
    _place(figures.reshape(-1, 10), solids, table, vertices, normals, grain, topology)
    colors = np.array([p.color for p in parts], np.float64).reshape(-1, 3)
    return Mesh(
        vertices,
        table,
        normals,
        topology,
        np.repeat(colors, solids[:, 3], axis=0),
        np.repeat(np.asarray(looks, np.int16), solids[:, 3]),
        grain,
    )


def _taper(part: Part) -> float:
    return max(part.taper, _LEAST_TAPER) if part.shape == "cylinder" else 1.0


def _look(category: str, material: Material) -> int:
    if material == Material.GLASS and "window" in category:
        return WINDOW
    if material == Material.GLASS and "mirror" in category:
        return MIRROR
    return int(material)


@jit
def _rotation(roll: float, pitch: float, yaw: float, turn: F64) -> None:
    """Rotation matrix of fixed-axis roll, pitch, yaw into ``turn`` (3, 3)."""
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    turn[0, 0], turn[0, 1], turn[0, 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    turn[1, 0], turn[1, 1], turn[1, 2] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    turn[2, 0], turn[2, 1], turn[2, 2] = -sp, cp * sr, cp * cr


@jit
def _newell(vertices: F64, first: int, index: I16, start: int, corners: int, normal: F64) -> None:
    """Unit normal of a polygon; Newell's sum also works for corners that nearly coincide."""
    normal[:] = 0.0
    for corner in range(corners):
        a = first + index[start + corner]
        b = first + index[start + (corner + 1) % corners]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            normal[i] += (vertices[a, j] - vertices[b, j]) * (vertices[a, k] + vertices[b, k])
    length = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if length > 0.0:
        normal /= length
    else:
        normal[2] = 1.0


@jit
def _place(figures: F64, solids: I32, table: I32, vertices: F64, normals: F64, grain: F64, topology: I16) -> None:
    """Scale, taper, turn and move the unit solids of all parts."""
    turn = np.empty((3, 3))
    for p in range(figures.shape[0]):
        sx, sy, sz, x, y, z, roll, pitch, yaw, taper = figures[p]
        _rotation(roll, pitch, yaw, turn)
        first, corner = table[p, 0], solids[p, 0]
        for i in range(solids[p, 1]):
            scale = taper if CORNERS[corner + i, 2] > 0.0 else 1.0
            a, b = CORNERS[corner + i, 0] * sx * scale, CORNERS[corner + i, 1] * sy * scale
            c = CORNERS[corner + i, 2] * sz
            vertices[first + i, 0] = turn[0, 0] * a + turn[0, 1] * b + turn[0, 2] * c + x
            vertices[first + i, 1] = turn[1, 0] * a + turn[1, 1] * b + turn[1, 2] * c + y
            vertices[first + i, 2] = turn[2, 0] * a + turn[2, 1] * b + turn[2, 2] * c + z
        longest = 0 if sx >= sy and sx >= sz else 1 if sy >= sz else 2
        for f in range(solids[p, 3]):
            row = table[p, 2] + f
            start, corners = FACES[solids[p, 2] + f, 0], FACES[solids[p, 2] + f, 1]
            topology[row, 0], topology[row, 1] = start, corners
            _newell(vertices, first, INDEX, start, corners, normals[row])
            for k in range(3):
                grain[row, k] = turn[k, longest]
