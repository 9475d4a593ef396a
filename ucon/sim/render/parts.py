"""Draws parts (convex solids): projects their corners and draws the faces that look at the camera.

Four in five faces of the parts in view show no pixel: half look away, and many are so far off that they fall between
pixel centres. They are discarded before their depth planes are computed.
"""

# mypy: disable-error-code="arg-type,operator,assignment,return-value,call-overload,type-var,misc"
# Scalars in kernels are typed by numba (float32, uint64), which Python's types cannot say.

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, I32, inlined, jit
from ucon.sim.render.shapes import INDEX, MOST_CORNERS, MOST_FACES, MOST_SIDES
from ucon.sim.render.spans import BLOCK_ROWS, fill
from ucon.sim.render.tables import CORNER_BLOCK

NEAR_M = 0.05
_NEAR = np.float32(NEAR_M)
_HALF = np.float32(0.5)
_ONE = np.float32(1.0)
_SLACK_PX, _SLACK_SHARE = np.float32(1 / 16), np.float32(4e-6)
"""A face between two columns of pixel centres is skipped only if it is clear of both by more than the rounding error:
this many pixels, plus this fraction of the distance from the first column."""

_CORNER = INDEX.astype(np.uint8)


@jit
def new_scratch() -> Any:
    """Working memory: corners, their pixels, faces to draw, plane distances; a polygon, its sides and spans."""
    corners = MOST_CORNERS + int(CORNER_BLOCK)
    return (
        np.empty((3, corners), np.float32),
        np.empty((4, corners), np.int32),
        np.empty(MOST_FACES + 1, np.int32),
        np.empty(MOST_FACES + 1, np.float32),
        np.empty((2, 2 * MOST_SIDES), np.float32),
        np.empty((2, int(BLOCK_ROWS)), np.float32),
        np.empty((2, int(BLOCK_ROWS)), np.int32),
    )


@inlined
def draw_part(p: int, geometry: Any, view: Any, window: Any, target: Any) -> None:
    """Project the corners of part ``p`` and draw those of its faces that look at the camera.

    Args:
        p: number of the part.
        geometry: tables of the home.
        view: camera and image.
        window: rectangle of the image to draw in.
        target: buffers and working memory.
    """
    vertices, parts, planes, _, frame, scratch = geometry
    points, pixels, fronts, distances = scratch[0], scratch[1], scratch[2], scratch[3]
    first_corner, corners = np.uint64(parts[p, 0]), np.uint64(parts[p, 1])
    whole = _to_camera(first_corner, corners, vertices, frame, points) >= _NEAR
    if whole and not _to_picture(corners, view, window, points, pixels):
        return
    first_face = np.uint64(parts[p, 2])
    count = _facing(first_face, first_face + np.uint64(parts[p, 3]), planes, frame, fronts, distances)
    for n in range(np.uint64(count)):
        _draw_face(np.uint64(fronts[n]), distances[n], whole, geometry, view, window, target)


@inlined
def _to_camera(first_corner: int, corners: int, vertices: F32, frame: F32, points: F32) -> float:
    """Write the corners' (right, up, ahead) to the first rows of ``points``; returns the least ahead."""
    cx, cy, cz = frame[3, 0], frame[3, 1], frame[3, 2]
    rx, ry = frame[0, 0], frame[0, 1]
    ux, uy, uz = frame[1, 0], frame[1, 1], frame[1, 2]
    fx, fy, fz = frame[2, 0], frame[2, 1], frame[2, 2]
    for start in range(np.uint64(0), corners, CORNER_BLOCK):
        for k in range(CORNER_BLOCK):
            i = start + np.uint64(k)
            v = first_corner + i
            dx, dy, dz = vertices[v, 0] - cx, vertices[v, 1] - cy, vertices[v, 2] - cz
            points[0, i] = dx * rx + dy * ry
            points[1, i] = dx * ux + dy * uy + dz * uz
            points[2, i] = dx * fx + dy * fy + dz * fz
    nearest = np.float32(1e9)
    for i in range(corners):
        nearest = min(nearest, points[2, i])
    return nearest


@inlined
def _to_picture(corners: int, view: Any, window: Any, points: F32, pixels: I32) -> bool:
    """Project corners in place and write their pixels to ``pixels``; returns whether the part may be in the window.

    Rows of ``pixels``: row, column, and the least and greatest column that rounding may give.
    """
    scale, middle_x, middle_y = np.float32(view[2]), np.float32(view[3]), np.float32(view[4])
    for start in range(np.uint64(0), corners, CORNER_BLOCK):
        for k in range(CORNER_BLOCK):
            i = start + np.uint64(k)
            inverse = scale / points[2, i]
            x = middle_x + points[0, i] * inverse
            y = middle_y - points[1, i] * inverse
            points[0, i], points[1, i] = x, y
            column = max(x, -_HALF) + _HALF
            slack = _SLACK_PX + abs(x) * _SLACK_SHARE
            pixels[0, i] = np.int32(max(y, -_HALF) + _HALF)
            pixels[1, i] = np.int32(column)
            pixels[2, i], pixels[3, i] = np.int32(column - slack), np.int32(column + slack)
    top, left = pixels[0, 0], pixels[1, 0]
    bottom, right = top, left
    for i in range(np.uint64(1), corners):
        top, bottom = min(top, pixels[0, i]), max(bottom, pixels[0, i])
        left, right = min(left, pixels[1, i]), max(right, pixels[1, i])
    return max(left, window[0]) < min(right, window[2]) and max(top, window[1]) < min(bottom, window[3])


@inlined
def _facing(begin: int, end: int, planes: F32, frame: F32, fronts: I32, distances: F32) -> int:
    """List the faces that look at the camera, with the distances of their planes; returns how many.

    Half of the faces do, in no predictable order. So every face is written, but counted only if it does; that needs no
    branch.
    """
    cx, cy, cz = frame[3, 0], frame[3, 1], frame[3, 2]
    count = np.uint64(0)
    for f in range(begin, end):
        distance = planes[f, 3] - (planes[f, 0] * cx + planes[f, 1] * cy + planes[f, 2] * cz)
        fronts[count], distances[count] = np.int32(f), distance
        count += np.uint64(distance < np.float32(-1e-6))
    return count


@inlined
def _draw_face(f: int, distance: float, whole: bool, geometry: Any, view: Any, window: Any, target: Any) -> None:
    """Draw one face, unless no pixel of the window can be in it."""
    _, _, planes, topology, frame, scratch = geometry
    points, pixels, polygon = scratch[0], scratch[1], scratch[4]
    start, corners = np.uint64(topology[f, 0]), np.uint64(topology[f, 1])
    if whole:
        rows = _rows_of_corners(start, corners, window, pixels)
        if rows[0] >= rows[1]:
            return
        for k in range(corners):
            i = _CORNER[start + k]
            polygon[0, k], polygon[1, k] = points[0, i], points[1, i]
    else:
        corners = _clip_near(start, corners, points, polygon, view)
        rows = _rows_of_polygon(corners, window, polygon)
        if rows[0] >= rows[1]:
            return
    scale, middle_x, middle_y = np.float32(view[2]), np.float32(view[3]), np.float32(view[4])
    step, over = _ONE / scale, _ONE / distance
    nx, ny, nz = planes[f, 0], planes[f, 1], planes[f, 2]
    a = (nx * frame[0, 0] + ny * frame[0, 1]) * step * over
    b = -(nx * frame[1, 0] + ny * frame[1, 1] + nz * frame[1, 2]) * step * over
    c = (nx * frame[2, 0] + ny * frame[2, 1] + nz * frame[2, 2]) * over
    c = c + a * (_HALF - middle_x) + b * (_HALF - middle_y)
    fill(f, corners, (a, b, c), rows, window, polygon, scratch[5], scratch[6], target)


@inlined
def _rows_of_corners(start: int, corners: int, window: Any, pixels: I32) -> tuple[int, int]:
    """Rows of a face with projected corners; none where it lies between two rows or two columns of pixel centres."""
    i = _CORNER[start]
    top, bottom, left, right = pixels[0, i], pixels[0, i], pixels[2, i], pixels[3, i]
    for k in range(np.uint64(1), corners):
        i = _CORNER[start + k]
        top, bottom = min(top, pixels[0, i]), max(bottom, pixels[0, i])
        left, right = min(left, pixels[2, i]), max(right, pixels[3, i])
    top, bottom = max(top, window[1]), min(bottom, window[3])
    if max(left, window[0]) >= min(right, window[2]):
        bottom = top
    return top, bottom


@inlined
def _rows_of_polygon(corners: int, window: Any, polygon: F32) -> tuple[int, int]:
    top, bottom = np.float32(1e9), np.float32(-1e9)
    for k in range(corners):
        top, bottom = min(top, polygon[1, k]), max(bottom, polygon[1, k])
    y0 = max(np.int32(max(top, -_HALF) + _HALF), window[1])
    y1 = np.int32(min(max(bottom, -_HALF), np.float32(window[3])) + _HALF)
    return y0, y1 if corners >= np.uint64(3) else y0


@inlined
def _clip_near(start: int, corners: int, points: F32, polygon: F32, view: Any) -> int:
    """Cut a face at the near plane and project what is left; returns its corners."""
    scale, middle_x, middle_y = np.float32(view[2]), np.float32(view[3]), np.float32(view[4])
    m = np.uint64(0)
    for k in range(corners):
        i = _CORNER[start + k]
        j = _CORNER[start + (k + np.uint64(1) if k + np.uint64(1) < corners else np.uint64(0))]
        if points[2, i] >= _NEAR:
            inverse = scale / points[2, i]
            polygon[0, m], polygon[1, m] = middle_x + points[0, i] * inverse, middle_y - points[1, i] * inverse
            m += np.uint64(1)
        if (points[2, i] >= _NEAR) != (points[2, j] >= _NEAR):
            t = (_NEAR - points[2, i]) / (points[2, j] - points[2, i])
            inverse = scale / _NEAR
            polygon[0, m] = middle_x + (points[0, i] + t * (points[0, j] - points[0, i])) * inverse
            polygon[1, m] = middle_y - (points[1, i] + t * (points[1, j] - points[1, i])) * inverse
            m += np.uint64(1)
    return m
