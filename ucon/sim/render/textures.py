"""Procedural textures: brightness of a material at a place.

Each function multiplies into the tones of a run (row 3) from its coordinates in metres (rows 1 and 2). ``foot`` is the
number of metres that a pixel covers: finer detail is faded out and lines are averaged over it, so nothing flickers.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

import numpy as np

from ucon.core.jit import F32, inlined, leaf
from ucon.core.rng import stream
from ucon.objects.model import Material
from ucon.sim.render.tessellate import MIRROR, WALL

BLOCK = np.uint64(32)
"""Pixels of a block of an inner loop."""

OPEN_SKY = 31
"""Look of a pixel that shows nothing."""

_WOOD, _FABRIC, _METAL, _GLASS = int(Material.WOOD), int(Material.FABRIC), int(Material.METAL), int(Material.GLASS)
_TILE, _PLANT, _PAPER = int(Material.TILE), int(Material.PLANT), int(Material.PAPER)
_PARQUET, _CONCRETE, _GRASS = int(Material.PARQUET), int(Material.CONCRETE), int(Material.GRASS)

SHADED = np.zeros(32, np.bool_)
"""Looks that have a texture of their own."""
SHADED[[_WOOD, _FABRIC, _METAL, _GLASS, _TILE, _PLANT, _PARQUET, _CONCRETE, _GRASS, MIRROR]] = True

_NOISE = (2 * stream(0, "texture noise").random(256) - 1).astype(np.float32)
_MIX = stream(0, "texture mix").permutation(256).astype(np.int32)

_SKIRTING, _SKIRTING_M = np.float32(0.8), np.float32(0.09)
_ZERO, _HALF, _ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
_SHIFT = np.float32(4096.0)
"""Added to coordinates, so that they are positive and truncation rounds down."""


@leaf
def outdoors(slope: float, pane: bool) -> tuple[float, float, float]:
    """Colour of the sky, or of the view through a window, at the slope of a ray; land below the horizon.

    Args:
        slope: up over ahead.
        pane: whether it is a window.

    Returns:
        Red, green, blue, 0 to 255.
    """
    height = min(max(np.float32(slope), -_ONE), _ONE)
    if height >= _ZERO or not pane:
        t = min(max(height, _ZERO) * np.float32(1.2), _ONE)
        return np.float32(226) - 74 * t, np.float32(238) - 42 * t, np.float32(250) - 8 * t
    t = min(-height * np.float32(2.0), _ONE)
    return np.float32(196) - 66 * t, np.float32(214) - 48 * t, np.float32(190) - 84 * t


@leaf
def _bounds(axis: int, room: int, rooms: F32, height: float) -> tuple[float, float]:
    """Extent of a room along a world axis."""
    if axis == 2:
        return _ZERO, np.float32(height)
    return rooms[room, axis], rooms[room, axis + 2]


@inlined
def paint_corners(
    u_axis: int, v_axis: int, look: int, room: int, x0: int, x1: int, rooms: F32, height: float, rows: F32
) -> None:
    """Darken floors, walls and ceilings softly towards the room's corners; draw skirting boards on walls.

    Args:
        u_axis: world axis of the first texture coordinate.
        v_axis: world axis of the second.
        look: of the face.
        room: its number.
        x0: first pixel of the run.
        x1: end of the run.
        rooms: (nr, 4) rectangles, metres.
        height: of the walls, metres.
        rows: working rows; row 3 is multiplied.
    """
    dark, slope = np.float32(0.86), np.float32(0.3)
    skirting = _SKIRTING_M if look == WALL else np.float32(-1e9)
    u0, u1 = _bounds(u_axis, room, rooms, height)
    v0, v1 = _bounds(v_axis, room, rooms, height)
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            u, v = rows[1, x], rows[2, x]
            near_u, near_v = min(u - u0, u1 - u), min(v - v0, v1 - v)
            shade = min(_ONE, dark + slope * near_u) * min(_ONE, dark + slope * near_v)
            rows[3, x] *= shade * (_SKIRTING if v < skirting else _ONE)


@inlined
def paint_material(look: int, x0: int, x1: int, foot_u: float, foot_v: float, rows: F32) -> None:
    """Multiply the texture of a material into a run.

    Args:
        look: material of the face.
        x0: first pixel of the run.
        x1: end of the run.
        foot_u: metres that a pixel covers along the first coordinate.
        foot_v: along the second.
        rows: working rows; row 3 is multiplied.
    """
    if look == _PARQUET:
        _boards(x0, x1, foot_u, foot_v, rows)
    elif look == _WOOD:
        _cells(x0, x1, 0.03, 0.7, 0.09, foot_u, foot_v, rows)
    elif look == _TILE:
        _tiles(x0, x1, foot_u, foot_v, rows)
    elif look == _FABRIC:
        _cells(x0, x1, 0.012, 0.012, 0.05, foot_u, foot_v, rows)
    elif look in (_PLANT, _GRASS):
        _cells(x0, x1, 0.04, 0.04, 0.16, foot_u, foot_v, rows)
        _cells(x0, x1, 0.23, 0.23, 0.07, foot_u, foot_v, rows)
    elif look == _CONCRETE:
        _cells(x0, x1, 0.09, 0.09, 0.05, foot_u, foot_v, rows)
    elif look == _METAL:
        _sheen(x0, x1, 0.9, 0.10, rows)
    elif look in (_GLASS, MIRROR):
        _sheen(x0, x1, 2.2, 0.16, rows)


@inlined
def _fade(cell: float, foot: float) -> float:
    """How much of a pattern shows: all of it at four pixels a cell, nothing at one and a half."""
    return min(max((np.float32(cell) / foot - np.float32(1.5)) * np.float32(0.4), _ZERO), _ONE)


@leaf
def _cells(
    x0: int, x1: int, size_u: float, size_v: float, amount: float, foot_u: float, foot_v: float, rows: F32
) -> None:
    """A pattern of cells, each with its own brightness."""
    strength = np.float32(amount) * _fade(size_u, foot_u) * _fade(size_v, foot_v)
    if strength <= np.float32(0.004):
        return
    per_u, per_v = np.float32(1.0 / size_u), np.float32(1.0 / size_v)
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            i = np.int32(rows[1, x] * per_u + _SHIFT)
            j = np.int32(rows[2, x] * per_v + _SHIFT + np.float32(_MIX[i & 255] & 15) * np.float32(0.25))
            rows[3, x] *= _ONE + strength * _NOISE[(i + _MIX[j & 255]) & 255]


@leaf
def _boards(x0: int, x1: int, foot_u: float, foot_v: float, rows: F32) -> None:
    """Boards 0.15 m wide and 1.2 m long, staggered, with dark joints."""
    strength = np.float32(0.12) * _fade(0.15, foot_u) * _fade(1.2, foot_v)
    if strength <= np.float32(0.004):
        return
    per_u, per_v = np.float32(1 / 0.15), np.float32(1 / 1.2)
    reach, inverse, most, joint = _joint(0.008, 0.15, foot_u)
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            a = rows[1, x] * per_u + _SHIFT
            i = np.int32(a)
            j = np.int32(rows[2, x] * per_v + _SHIFT + _NOISE[i & 255])
            away = (_HALF - abs(a - np.float32(i) - _HALF)) * np.float32(0.15)
            line = min(max((reach - away) * inverse, _ZERO), most)
            rows[3, x] *= _ONE + strength * _NOISE[(i + _MIX[j & 255]) & 255] - joint * line


@leaf
def _tiles(x0: int, x1: int, foot_u: float, foot_v: float, rows: F32) -> None:
    """Square tiles of 0.33 m with grout between them."""
    strength = np.float32(0.05) * _fade(0.33, foot_u) * _fade(0.33, foot_v)
    per = np.float32(1 / 0.33)
    reach_u, inverse_u, most_u, joint_u = _joint(0.010, 0.33, foot_u)
    reach_v, inverse_v, most_v, joint_v = _joint(0.010, 0.33, foot_v)
    if joint_u <= _ZERO and joint_v <= _ZERO:
        return
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            a, b = rows[1, x] * per + _SHIFT, rows[2, x] * per + _SHIFT
            i, j = np.int32(a), np.int32(b)
            away_u = (_HALF - abs(a - np.float32(i) - _HALF)) * np.float32(0.33)
            away_v = (_HALF - abs(b - np.float32(j) - _HALF)) * np.float32(0.33)
            line_u = joint_u * min(max((reach_u - away_u) * inverse_u, _ZERO), most_u)
            line_v = joint_v * min(max((reach_v - away_v) * inverse_v, _ZERO), most_v)
            rows[3, x] *= _ONE + strength * _NOISE[(i + _MIX[j & 255]) & 255] - max(line_u, line_v)


@inlined
def _joint(wide: float, cell: float, foot: float) -> tuple[float, float, float, float]:
    """A thin dark line averaged over a pixel: its reach, one over the pixel, its peak and its depth."""
    wide, foot = np.float32(wide), np.float32(foot)
    inverse = _ONE / foot
    return (wide + foot) * _HALF, inverse, min(_ONE, wide * inverse), np.float32(0.28) * _fade(cell, foot)


@leaf
def _sheen(x0: int, x1: int, per_metre: float, amount: float, rows: F32) -> None:
    """Broad slanting reflections."""
    per, amount = np.float32(per_metre), np.float32(amount)
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            a = (rows[1, x] + rows[2, x] * np.float32(0.6)) * per + _SHIFT
            wave = abs(a - np.float32(np.int32(a)) - _HALF) * np.float32(4.0) - _ONE
            rows[3, x] *= _ONE + amount * wave
