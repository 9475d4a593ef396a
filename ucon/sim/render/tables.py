"""The flat tables that the kernels read, and the kernel that writes a mesh into them at a pose.

A *group* is one instance: a run of parts. A *part* is a convex solid: a run of corners and of faces.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, U8, jit
from ucon.sim.render.shapes import INDEX
from ucon.sim.render.tessellate import CEILING, WALL, Mesh

CORNER_BLOCK = np.uint64(8)
"""Corners are projected in blocks of this many; a box is one block."""


class Tables(NamedTuple):
    """Geometry of a home: ng groups, np parts, nf faces, nv corners."""

    vertices: F32  # (nv, 3) world
    face_planes: F32
    """(nf, 4) unit normal, and its dot product with any corner."""
    face_topology: I16
    """(nf, 2) start in the index table, number of corners."""
    face_instance: I16  # (nf,)
    face_color: U8
    """(nf, 4) lit colour and look."""
    face_axes: U8
    """(nf, 2) texture axes (0: xy, 1: yz, 2: xz; +4 where the grain runs along the first); room + 1 of structure."""
    parts: I32
    """(np, 5) first corner, corners, first face, faces, link."""
    part_boxes: F32  # (np, 6)
    groups: I32
    """(ng, 2) first part, number of parts; none for removed instances."""
    group_boxes: F32  # (ng, 6)


def empty_tables(groups: int, parts: int, faces: int, vertices: int) -> Tables:
    """Tables of the given sizes, not filled."""
    return Tables(
        np.empty((vertices + int(CORNER_BLOCK), 3), np.float32)[:vertices],  # the last block may read past the end
        np.empty((faces, 4), np.float32),
        np.empty((faces, 2), np.int16),
        np.empty(faces, np.int16),
        np.empty((faces, 4), np.uint8),
        np.empty((faces, 2), np.uint8),
        np.empty((parts, 5), np.int32),
        np.empty((parts, 6), np.float32),
        np.zeros((groups, 2), np.int32),
        np.empty((groups, 6), np.float32),
    )


def copy_tables(source: Tables, target: Tables) -> None:
    """Write the rows of ``source`` over the first rows of ``target``."""
    for name in Tables._fields:
        shared = getattr(source, name)
        getattr(target, name)[: len(shared)] = shared


def copied_tables(source: Tables) -> Tables:
    """A copy that can be written to."""
    rows = (source.groups, source.parts, source.face_planes, source.vertices)
    target = empty_tables(*map(len, rows))
    copy_tables(source, target)
    return target


def tables_nbytes(tables: Tables) -> int:
    """Memory of all tables, bytes."""
    return sum(table.nbytes for table in tables)


def write_group(
    tables: Tables, mesh: Mesh, group: int, at: tuple[int, int, int], turn: F64, shift: F64, room: int = -1
) -> tuple[int, int, int]:
    """Append a mesh as one group.

    Args:
        tables: written to.
        mesh: polygons of the model.
        group: its number.
        at: (part, face, corner) where it begins.
        turn: (3, 3) rotation.
        shift: (3,) world metres.
        room: number of the room for structure, which is shaded towards the corners; -1 for items.

    Returns:
        (part, face, corner) where the next group begins.
    """
    part, face, vertex = at
    np_, nf, nv = len(mesh.parts), len(mesh.normals), len(mesh.vertices)
    tables.groups[group] = part, np_
    if np_:
        tables.parts[part : part + np_] = mesh.parts + np.array([vertex, 0, face, 0, 0], np.int32)
        tables.face_topology[face : face + nf] = mesh.topology
        tables.face_instance[face : face + nf] = group
        tables.face_color[face : face + nf, 3] = mesh.looks
        tables.face_axes[face : face + nf, 1] = room + 1
        bake(tables, mesh, group, turn, shift)
    return part + np_, face + nf, vertex + nv


def bake(tables: Tables, mesh: Mesh, group: int, turn: F64, shift: F64, link: int = -2) -> None:
    """Write the world geometry of a group at a pose.

    Args:
        tables: written to.
        mesh: polygons of the model.
        group: its number.
        turn: (3, 3) rotation.
        shift: (3,) world metres.
        link: write only the parts that this joint carries; -2 for all.
    """
    _bake(
        tables.vertices,
        tables.face_planes,
        tables.face_color,
        tables.face_axes,
        tables.parts,
        tables.part_boxes,
        tables.groups[group],
        tables.group_boxes[group],
        (mesh.vertices, mesh.normals, mesh.topology, mesh.colors, mesh.grain),
        np.ascontiguousarray(turn, np.float64),
        np.asarray(shift, np.float64),
        link,
    )


@jit
def _bake(
    vertices: F32,
    planes: F32,
    color: U8,
    axes: U8,
    parts: I32,
    boxes: F32,
    group: I32,
    group_box: F32,
    mesh: Any,
    turn: F64,
    shift: F64,
    link: int,
) -> None:
    local = mesh[0]
    first = group[0]
    v_base, f_base = parts[first, 0], parts[first, 2]
    for p in range(first, first + group[1]):
        if link != -2 and parts[p, 4] != link:
            continue
        for k in range(3):
            boxes[p, k], boxes[p, 3 + k] = np.float32(np.inf), np.float32(-np.inf)
        for v in range(parts[p, 0], parts[p, 0] + parts[p, 1]):
            for k in range(3):
                x = shift[k]
                for j in range(3):
                    x += turn[k, j] * local[v - v_base, j]
                vertices[v, k] = x
                boxes[p, k] = min(boxes[p, k], vertices[v, k])
                boxes[p, 3 + k] = max(boxes[p, 3 + k], vertices[v, k])
        for f in range(parts[p, 2], parts[p, 2] + parts[p, 3]):
            _bake_face(f, f_base, parts[p, 0], vertices, planes, color, axes, mesh, turn)
    for k in range(3):
        group_box[k], group_box[3 + k] = np.float32(np.inf), np.float32(-np.inf)
        for p in range(first, first + group[1]):
            group_box[k] = min(group_box[k], boxes[p, k])
            group_box[3 + k] = max(group_box[3 + k], boxes[p, 3 + k])


@jit
def _bake_face(
    f: int, f_base: int, v: int, vertices: F32, planes: F32, color: U8, axes: U8, mesh: Any, turn: F64
) -> None:
    """Plane, lit colour and texture axes of one face whose part begins at corner ``v``."""
    _, normals, topology, colors, grains = mesh
    row = f - f_base
    along = np.empty(3)
    for k in range(3):
        planes[f, k] = turn[k, 0] * normals[row, 0] + turn[k, 1] * normals[row, 1] + turn[k, 2] * normals[row, 2]
        along[k] = abs(turn[k, 0] * grains[row, 0] + turn[k, 1] * grains[row, 1] + turn[k, 2] * grains[row, 2])
    n0, n1, n2 = planes[f, 0], planes[f, 1], planes[f, 2]
    corner = v + INDEX[topology[row, 0]]
    planes[f, 3] = n0 * vertices[corner, 0] + n1 * vertices[corner, 1] + n2 * vertices[corner, 2]
    light = _light(n0, n1, n2) if color[f, 3] != CEILING else 0.92
    for k in range(3):
        color[f, k] = np.uint8(min(255.0, colors[row, k] * light))
    grain = 4 * (color[f, 3] != WALL)
    if abs(n2) >= 0.7:
        axes[f, 0] = 0 + grain * (along[0] > along[1])
    elif abs(n0) > abs(n1):
        axes[f, 0] = 1 + grain * (along[1] > along[2])
    else:
        axes[f, 0] = 2 + grain * (along[0] > along[2])


@jit
def _light(x: float, y: float, z: float) -> float:
    """Soft daylight from above and one side: all six directions of a room differ."""
    return 0.80 + (0.16 if z > 0.0 else 0.08) * z + 0.07 * x + 0.03 * y + 0.05 * abs(x)
