"""From the visibility buffer to colours, depth, instance numbers and pixel counts.

The picture is walked in runs of pixels of one face. What depends on the face is computed once a run; within it the
texture coordinates (two of the three world coordinates) are linear in the pixel times its depth, so there is no
division and no branch on the material in the inner loops.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.sim.render.base import SKY_DEPTH_M
from ucon.sim.render.kernels import F32, F64, I16, I32, U8, borrowed, jit
from ucon.sim.render.raster import camera_frame
from ucon.sim.render.tessellate import WINDOW
from ucon.sim.render.textures import OPEN_SKY, SHADED, outdoors, paint_corners, paint_material

_ONE = np.float32(1.0)
_DIM, _BRIGHT, _REACH_M = np.float32(0.74), np.float32(0.28), np.float32(1.8)
"""Brightness far away, what nearness adds, and how near that is."""
_FARTHEST = np.float32(SKY_DEPTH_M)
_LEAST = np.float32(1.0 / SKY_DEPTH_M)


@jit
def resolve(
    faces: I32,
    inverse_depth: F32,
    tables: Any,
    camera: F64,
    rooms: F32,
    wall_height: float,
    textured: bool,
    rgb: U8,
    depth: F32,
    instance: I16,
    counts: I32,
) -> None:
    """Fill those outputs that are not empty."""
    height, width = faces.shape
    frame = np.empty((4, 3), np.float32)
    camera_frame(camera, frame)
    scale = np.float32(width * 0.5 / camera[7])
    scratch = np.empty((4, width), np.float32)
    sight = np.empty((4, 3), np.float32)
    geometry = (borrowed(tables.face_planes), borrowed(tables.face_color), borrowed(tables.face_axes), borrowed(rooms))
    rows, row_of = borrowed(scratch), borrowed(sight)
    seen, owner, over = borrowed(faces), borrowed(tables.face_instance), borrowed(inverse_depth)
    to_rgb, to_depth, to_instance = borrowed(rgb.reshape(-1)), borrowed(depth), borrowed(instance)
    want_rgb, want_depth, want_instance = rgb.size > 0, depth.size > 0, instance.size > 0
    for k in range(3):
        row_of[1, k], row_of[2, k], row_of[3, k] = frame[0, k] / scale, frame[2, k], frame[3, k]
    counts[:] = 0
    for y in range(height):
        up = np.float32((height * 0.5 - camera[9] - y) / scale)
        side = np.float32((camera[8] - width * 0.5) / scale)
        for k in range(3):
            row_of[0, k] = frame[2, k] + up * frame[1, k] + side * frame[0, k]
        if want_depth or want_rgb:
            for x in range(width):
                rows[0, x] = min(_ONE / max(over[y, x], _LEAST), _FARTHEST)
        if want_depth:
            for x in range(width):
                to_depth[y, x] = rows[0, x]
        if want_rgb:
            for x in range(width):
                rows[3, x] = _DIM + _BRIGHT * min(_ONE, _REACH_M / (rows[0, x] + np.float32(0.8)))
        x0 = 0
        while x0 < width:
            f = seen[y, x0]
            x1 = x0 + 1
            while x1 < width and seen[y, x1] == f:
                x1 += 1
            number = owner[f] if f >= 0 else np.int16(-1)
            if counts.size > 0 and f >= 0:
                counts[number] += x1 - x0
            if want_instance:
                for x in range(np.uint64(x0), np.uint64(x1)):
                    to_instance[y, x] = number
            if want_rgb:
                at = np.uint64(y * width)
                _color_run(f, at, np.uint64(x0), np.uint64(x1), geometry, wall_height, row_of, rows, textured, to_rgb)
            x0 = x1


@jit
def _color_run(
    f: int,
    at: int,
    x0: int,
    x1: int,
    geometry: Any,
    wall_height: float,
    sight: F32,
    rows: F32,
    textured: bool,
    rgb: U8,
) -> None:
    """Colour the pixels x0 to x1 of the row that begins at pixel number ``at``, all of face ``f``."""
    planes, colors, axes, rooms = geometry
    look = colors[f, 3] if f >= 0 else OPEN_SKY
    if look == OPEN_SKY or look == WINDOW:
        sky = outdoors(sight[0, 2], look == WINDOW)
        _write(rgb, at, x0, x1, sky[0], sky[1], sky[2])
        return
    red, green, blue = np.float32(colors[f, 0]), np.float32(colors[f, 1]), np.float32(colors[f, 2])
    if not textured:
        _write(rgb, at, x0, x1, red, green, blue)
        return
    code, room = axes[f, 0], axes[f, 1]
    if room > 0 or SHADED[look]:
        _coordinates(code, x0, x1, sight, rows)
        if room > 0:
            paint_corners(*_axes_of(code), look, room - 1, x0, x1, rooms, wall_height, rows)
        if SHADED[look]:
            foot_u, foot_v = _footprint(f, code, rows[0, (x0 + x1) >> np.uint64(1)], planes, sight)
            paint_material(look, x0, x1, foot_u, foot_v, rows)
    brightest = np.float32(255.0) / max(red, green, blue, _ONE)
    for x in range(x0, x1):
        tone = min(rows[3, x], brightest)
        i = (at + x) * np.uint64(3)
        rgb[i] = np.uint8(np.int32(red * tone))
        rgb[i + np.uint64(1)] = np.uint8(np.int32(green * tone))
        rgb[i + np.uint64(2)] = np.uint8(np.int32(blue * tone))


@jit
def _write(rgb: U8, at: int, x0: int, x1: int, red: float, green: float, blue: float) -> None:
    r, g, b = np.uint8(np.int32(red)), np.uint8(np.int32(green)), np.uint8(np.int32(blue))
    for x in range(x0, x1):
        i = (at + x) * np.uint64(3)
        rgb[i], rgb[i + np.uint64(1)], rgb[i + np.uint64(2)] = r, g, b


@jit
def _axes_of(code: int) -> tuple[int, int]:
    """World axes that a face's texture runs along; the second is the way of the grain."""
    plane = code & 3
    u, v = (0, 1) if plane == 0 else (1, 2) if plane == 1 else (0, 2)
    return (v, u) if code & 4 else (u, v)


@jit
def _coordinates(code: int, x0: int, x1: int, sight: F32, rows: F32) -> None:
    """Texture coordinates in metres of a run, into rows 1 and 2."""
    u, v = _axes_of(code)
    at_u, from_u, step_u = sight[3, u], sight[0, u], sight[1, u]
    at_v, from_v, step_v = sight[3, v], sight[0, v], sight[1, v]
    for x in range(x0, x1):
        place = np.float32(np.int32(x))
        rows[1, x] = at_u + rows[0, x] * (from_u + place * step_u)
        rows[2, x] = at_v + rows[0, x] * (from_v + place * step_v)


@jit
def _footprint(f: int, code: int, depth: float, planes: F32, sight: F32) -> tuple[float, float]:
    """Metres of texture that a pixel covers along both axes, for fading what is too fine to be seen."""
    away = planes[f, 3]
    for k in range(3):
        away -= planes[f, k] * sight[3, k]
    stretch = max(_ONE, depth / max(abs(away), np.float32(0.05)))
    step = abs(sight[1, 0]) + abs(sight[1, 1])
    u, v = _axes_of(code)
    if code & 3 == 0:
        flat_u = abs(sight[1, u]) + step * stretch * abs(sight[2, u])
        return depth * flat_u, depth * (abs(sight[1, v]) + step * stretch * abs(sight[2, v]))
    across = depth * step * stretch
    return (depth * step, across) if u == 2 else (across, depth * step)
