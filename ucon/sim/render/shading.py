"""From the visibility buffer to colours, depth, instance numbers and pixel counts.

The image is processed in runs of pixels of one face. What depends on the face is computed once per run. Within a run,
the texture coordinates (two of the three world coordinates) are linear in the pixel times its depth, so the inner loops
have no division and no branch on the material. They run over whole blocks of pixels, which compile to vector
instructions even for short runs; what they write past the end of a run is overwritten by the next run.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I16, I32, U8, U32, inlined, jit
from ucon.sim.render.base import SKY_DEPTH_M
from ucon.sim.render.raster import camera_frame
from ucon.sim.render.tessellate import WINDOW
from ucon.sim.render.textures import BLOCK, OPEN_SKY, SHADED, outdoors, paint_corners, paint_material

_ONE = np.float32(1.0)
_STEP = np.uint64(1)
_G, _B, _LOOK = np.uint32(8), np.uint32(16), np.uint32(24)
_PANE = np.uint32(WINDOW)
_DIM, _BRIGHT, _REACH_M = np.float32(0.74), np.float32(0.28), np.float32(1.8)
"""Brightness far away, added brightness nearby, and the distance of that, metres."""
_FARTHEST = np.float32(SKY_DEPTH_M)
_LEAST = np.float32(1.0 / SKY_DEPTH_M)


@jit
def resolve(
    size: tuple[int, int],
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
    """Write the outputs whose arrays are not empty.

    Args:
        size: width and height, pixels.
        faces: as :func:`ucon.sim.render.raster.rasterise` writes them.
        inverse_depth: of the same.
        tables: polygons, see :class:`ucon.sim.render.tables.Tables`.
        camera: (10,) float64.
        rooms: (nr, 4) rectangles, metres.
        wall_height: metres.
        textured: whether to apply textures.
        rgb: (H, W, 3) uint8, or empty.
        depth: (H, W) float32, or empty.
        instance: (H, W) int16, or empty.
        counts: (n_instances,) int32, or empty.
    """
    width, height = size
    frame = np.empty((4, 3), np.float32)
    camera_frame(camera, frame)
    padded = width + BLOCK
    rows, line = np.zeros((5, padded), np.float32), np.empty(padded, np.uint32)
    sight = np.empty((4, 3), np.float32)
    geometry = (tables.face_planes, tables.face_color, tables.face_axes, rooms, np.float32(wall_height))
    palette = tables.face_color.reshape(-1).view(np.uint32)
    numbers, colors = instance.reshape(-1), rgb.reshape(-1)
    counts[:] = 0
    for y in range(height):
        at = np.uint64(y * width)
        if depth.size > 0 or rgb.size > 0:
            _depths(y, width, inverse_depth, rows, depth)
        if counts.size > 0:
            _count_row(at, np.uint64(width), faces, tables.face_instance, counts)
        if instance.size > 0:
            _number_row(at, np.uint64(width), faces, tables.face_instance, numbers)
        if rgb.size > 0:
            _look_along(y, height, width, camera, frame, sight)
            if textured:
                _color_row(at, np.uint64(width), faces, geometry, sight, rows, line)
            else:
                _flat_row(at, np.uint64(width), faces, palette, sight[0, 2], line)
            _unpack(line, y, width, colors)


@inlined
def _depths(y: int, width: int, inverse_depth: F32, rows: F32, depth: F32) -> None:
    """Write the depths of a row to row 0 and the output, and the brightness at that depth to row 4."""
    at = np.uint64(y * width)
    for x in range(width):
        rows[0, x] = min(_ONE / max(inverse_depth[at + np.uint64(x)], _LEAST), _FARTHEST)
    for x in range(width):
        rows[4, x] = _DIM + _BRIGHT * min(_ONE, _REACH_M / (rows[0, x] + np.float32(0.8)))
    if depth.size > 0:
        for x in range(width):
            depth[y, x] = rows[0, x]


@inlined
def _look_along(y: int, height: int, width: int, camera: F64, frame: F32, sight: F32) -> None:
    """Write the rays of a row to ``sight``: the first pixel's, the step to the next, straight ahead, the camera."""
    scale = np.float32(width * 0.5 / camera[7])
    up = np.float32((height * 0.5 - camera[9] - y) / scale)
    side = np.float32((camera[8] - width * 0.5) / scale)
    for k in range(3):
        sight[0, k] = frame[2, k] + up * frame[1, k] + side * frame[0, k]
        sight[1, k], sight[2, k], sight[3, k] = frame[0, k] / scale, frame[2, k], frame[3, k]


@inlined
def _run_end(at: int, x: int, width: int, faces: I32) -> int:
    """Column at which the run of one face that begins at ``x`` ends."""
    f = faces[at + x]
    x += _STEP
    while x < width and faces[at + x] == f:
        x += _STEP
    return x


@inlined
def _count_row(at: int, width: int, faces: I32, owner: I16, counts: I32) -> None:
    x0 = np.uint64(0)
    while x0 < width:
        f, x1 = faces[at + x0], _run_end(at, x0, width, faces)
        if f >= 0:
            counts[owner[f]] += np.int32(x1 - x0)
        x0 = x1


@inlined
def _number_row(at: int, width: int, faces: I32, owner: I16, numbers: I16) -> None:
    """Instance numbers of a row, pixel by pixel without a branch: the ends of runs are unpredictable."""
    for x in range(width):
        f = faces[at + x]
        number = owner[np.uint64(max(f, np.int32(0)))]
        numbers[at + x] = number if f >= 0 else np.int16(-1)


@inlined
def _flat_row(at: int, width: int, faces: I32, palette: U32, slope: float, line: U32) -> None:
    """Colours of the faces, looked up pixel by pixel; sky and panes, which depend on the row, in a second pass."""
    for x in range(width):
        line[x] = palette[np.uint64(max(faces[at + x], np.int32(0)))]
    sky, pane = _packed(outdoors(slope, False)), _packed(outdoors(slope, True))
    for x in range(width):
        color = line[x]
        color = pane if color >> _LOOK == _PANE else color
        line[x] = sky if faces[at + x] < 0 else color


@inlined
def _color_row(at: int, width: int, faces: I32, geometry: Any, sight: F32, rows: F32, line: U32) -> None:
    """Shade a row, run by run."""
    x0 = np.uint64(0)
    while x0 < width:
        f, x1 = faces[at + x0], _run_end(at, x0, width, faces)
        _color_run(f, x0, x1, geometry, sight, rows, line)
        x0 = x1


@inlined
def _packed(color: tuple[float, float, float]) -> int:
    """A colour as one word, red in the lowest byte."""
    word = np.uint32(np.int32(color[0])) | (np.uint32(np.int32(color[1])) << _G)
    return np.uint32(word | (np.uint32(np.int32(color[2])) << _B))


@inlined
def _unpack(line: U32, y: int, width: int, rgb: U8) -> None:
    """Write a row of packed colours, whole blocks first."""
    first = np.uint64(y * width * 3)
    whole = np.uint64(width) // BLOCK * BLOCK
    for start in range(np.uint64(0), whole, BLOCK):
        for k in range(BLOCK):
            _put(line[start + np.uint64(k)], first + np.uint64(3) * (start + np.uint64(k)), rgb)
    for x in range(whole, np.uint64(width)):
        _put(line[x], first + np.uint64(3) * x, rgb)


@inlined
def _put(color: int, i: int, rgb: U8) -> None:
    rgb[i] = np.uint8(color)
    rgb[i + np.uint64(1)] = np.uint8(color >> _G)
    rgb[i + np.uint64(2)] = np.uint8(color >> _B)


@inlined
def _color_run(
    f: int,
    x0: int,
    x1: int,
    geometry: Any,
    sight: F32,
    rows: F32,
    line: U32,
) -> None:
    """Colour the pixels x0 to x1 of a row, all of face ``f``, into ``line``."""
    planes, colors, axes, rooms, wall_height = geometry
    look = colors[f, 3] if f >= 0 else OPEN_SKY
    if look in (OPEN_SKY, WINDOW):
        word = _packed(outdoors(sight[0, 2], look == WINDOW))
        for x in range(x0, x1):
            line[x] = word
        return
    red, green, blue = np.float32(colors[f, 0]), np.float32(colors[f, 1]), np.float32(colors[f, 2])
    code, room = axes[f, 0], axes[f, 1]
    tone = 4
    if room > 0 or SHADED[look]:
        tone = 3
        u, v = _axes_of(code)
        _coordinates(u, v, x0, x1, sight, rows)
        if room > 0:
            paint_corners(u, v, look, room - 1, x0, x1, rooms, wall_height, rows)
        if SHADED[look]:
            foot_u, foot_v = _footprint(f, code, rows[0, (x0 + x1) >> _STEP], planes, sight)
            paint_material(look, x0, x1, foot_u, foot_v, rows)
    _pack(line, x0, x1, red, green, blue, tone, rows)


@inlined
def _pack(line: U32, x0: int, x1: int, red: float, green: float, blue: float, tone: int, rows: F32) -> None:
    """Colour times tone, as one word per pixel."""
    brightest = np.float32(255.0) / max(red, green, blue, _ONE)
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            light = min(rows[tone, x], brightest)
            color = np.uint32(np.int32(red * light)) | (np.uint32(np.int32(green * light)) << _G)
            line[x] = color | (np.uint32(np.int32(blue * light)) << _B)


@inlined
def _axes_of(code: int) -> tuple[int, int]:
    """World axes that a face's texture runs along; the second is the direction of the grain."""
    plane = code & 3
    u, v = (0, 1) if plane == 0 else (1, 2) if plane == 1 else (0, 2)
    return (v, u) if code & 4 else (u, v)


@inlined
def _coordinates(u: int, v: int, x0: int, x1: int, sight: F32, rows: F32) -> None:
    """Texture coordinates in metres of a run into rows 1 and 2, its tone before texture into row 3."""
    at_u, from_u, step_u = sight[3, u], sight[0, u], sight[1, u]
    at_v, from_v, step_v = sight[3, v], sight[0, v], sight[1, v]
    for start in range(x0, x1, BLOCK):
        for k in range(BLOCK):
            x = start + np.uint64(k)
            place = np.float32(np.int32(x))
            rows[1, x] = at_u + rows[0, x] * (from_u + place * step_u)
            rows[2, x] = at_v + rows[0, x] * (from_v + place * step_v)
            rows[3, x] = rows[4, x]


@inlined
def _footprint(f: int, code: int, depth: float, planes: F32, sight: F32) -> tuple[float, float]:
    """Metres of texture that a pixel covers along both axes, for fading patterns too fine to be seen."""
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
