"""One frame as arrays: a patch of floor ahead of the agent and the things in view, in the agent's frame of reference.

Nothing is remembered here; :mod:`models.nets.end_to_end.floor_memory` combines frames over time. Cells are 0.25 m and
centred on nodes; row f, column l of the patch is the cell f - 1 ahead and l - 40 to the left of the agent.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from models.nets.end_to_end.ego_kernels import EXPLORED, mark_floor, mark_pairs, measure
from ucon.perception.mapping.detections import STRUCTURE_KINDS, Detections
from ucon.perception.mapping.semantic_map import require_width

CELL_M = 0.25
AHEAD, ASIDE, BEHIND = 40, 40, 1
"""Cells of the patch ahead (10 m), to either side (10 m), and behind."""
ROWS, COLUMNS = AHEAD + BEHIND + 1, 2 * ASIDE + 1
N_CELLS = ROWS * COLUMNS
N_THINGS = 32
"""Most things of one frame: the target first, then by decreasing number of pixels."""
N_PAIRS = 192
"""Most (thing, cell) pairs of one frame."""
THING_FEATURES = (
    *("ahead_m", "left_m", "up_m", "nearest_m", "sin", "cos"),
    *("u0", "v0", "u1", "v1", "pixels", "score", "just_opened"),
)
"""Features of a thing.

Mean of its seen points relative to the camera, in metres ahead, left and up; horizontal metres to the nearest point;
sine and cosine of its bearing; its box in shares of the image; log(pixels / 64); the detector's score; 1 if this step
opened it.
"""
_FAR_M, _LOOK_M = 25.0, 2.0
#: Cells that a sight line passed over are explored up to this distance.
_CARVE_M = 8.0
_STRIDE = 2
_N_BINS = 120

F32 = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class EgoView:
    """Arrays of one frame; unused tracks and pairs are -1, unused rows of ``things`` 0."""

    patch: NDArray[np.uint8]
    """(ROWS, COLUMNS) uint8, bits EXPLORED, SEEN_FLOOR, BLOCKED and OPAQUE."""
    look: NDArray[np.uint8]
    """(ROWS, COLUMNS) uint8, 255 exp(-d / 2 m); d is the least horizontal distance from which the cell was seen."""
    names: tuple[str, ...]
    """Category of each thing, at most N_THINGS."""
    tracks: NDArray[np.int16]
    """(N_THINGS,) track number of each thing."""
    things: NDArray[np.float16]
    """(N_THINGS, len(THING_FEATURES)) features of each thing."""
    pair_cell: NDArray[np.int16]
    """(N_PAIRS,) index of a cell of the patch."""
    pair_row: NDArray[np.int16]
    """(N_PAIRS,) index of the thing seen in it."""


def ego_view(depth: F32, pitch_rad: float, camera_m: float, info: Mapping[str, Any], target: str) -> EgoView:
    """Convert one frame to arrays.

    Args:
        depth: (H, W) float32, distance along the optical axis in metres.
        pitch_rad: of the camera, up positive.
        camera_m: height of the camera above the floor.
        info: of the step, with ``detections``, ``tracks`` and ``opened``.
        target: category that is listed first.

    Raises:
        ConfigError: the field of view is not 90 degrees.
    """
    require_width(info)
    found = Detections.from_info(info)
    points, spread = _points(depth, pitch_rad, camera_m)
    patch, look, cell = _floor(points, spread)
    n_tracks = int(max(found.image.max(), found.track.max(initial=0))) + 1
    shown = np.zeros(n_tracks + 1, bool)  # index -1 is the last entry: pixels of no track
    shown[found.image[np.isfinite(spread)]] = True
    rows, names = _chosen(found, shown, target)
    table = np.full(n_tracks + 1, -1, np.int16)
    table[found.track[rows]] = np.arange(len(rows))
    image = table[found.image]
    things = np.zeros((N_THINGS, len(THING_FEATURES)), np.float32)
    tracks = np.full(N_THINGS, -1, np.int16)
    tracks[: len(rows)] = found.track[rows]
    middle = _measure(image, points, spread, len(rows), camera_m, things)
    things[: len(rows), 11] = 1.0 if found.score is None else found.score[rows]
    things[: len(rows), 12] = np.isin(found.track[rows], np.asarray(info.get("opened", ()), np.int64))
    pair_cell, pair_row = _pairs(image, cell, middle)
    return EgoView(patch, look, names, tracks, things.astype(np.float16), pair_cell, pair_row)


@lru_cache(maxsize=8)
def _rays(height: int, width: int) -> tuple[F32, F32]:
    """Tangents of the sight lines: upwards (H, 1) and to the left (1, W)."""
    focal_px = 0.5 * width
    up = (0.5 * height - np.arange(height) - 0.5) / focal_px
    left = (0.5 * width - np.arange(width) - 0.5) / focal_px
    return up[:, None].astype(np.float32), left[None].astype(np.float32)


def _points(depth: F32, pitch_rad: float, camera_m: float) -> tuple[F32, F32]:
    """Points (3, H, W) in metres ahead, to the left, and above the floor, and their horizontal distances (H, W).

    Distances are inf without a hit.
    """
    up, left = _rays(*depth.shape)
    cos, sin = np.float32(np.cos(pitch_rad)), np.float32(np.sin(pitch_rad))
    points = np.empty((3, *depth.shape), np.float32)
    np.multiply(depth, cos - sin * up, out=points[0])
    np.multiply(depth, left, out=points[1])
    np.multiply(depth, sin + cos * up, out=points[2])
    points[2] += camera_m
    spread = np.hypot(points[0], points[1])
    return points, np.where((depth > 0) & (depth < _FAR_M), spread, np.float32(np.inf))


@lru_cache(maxsize=1)
def _cells() -> tuple[F32, NDArray[np.int64]]:
    """Distance (ROWS, COLUMNS) in metres and direction bin of every cell of the patch."""
    f, left = np.mgrid[-BEHIND : AHEAD + 1, -ASIDE : ASIDE + 1] * CELL_M
    return np.hypot(f, left).astype(np.float32), _bins(f, left)


def _bins(ahead: NDArray[Any], left: NDArray[Any]) -> NDArray[np.int64]:
    """Index of the direction bin, 0 to 119, counter-clockwise from straight ahead."""
    turn = np.arctan2(left, ahead) * (_N_BINS / (2 * np.pi))
    return np.floor(turn + 0.5).astype(np.int64) % _N_BINS


def _floor(points: F32, spread: F32) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.int64]]:
    """Patch (ROWS, COLUMNS), looks (ROWS, COLUMNS), and the cell (h, w) of every second point, -1 outside the patch."""
    flags, nearest = np.zeros(N_CELLS, np.uint8), np.full(N_CELLS, np.inf, np.float32)
    cell = np.empty((-(-spread.shape[0] // _STRIDE), -(-spread.shape[1] // _STRIDE)), np.int64)
    mark_floor(points, spread, _STRIDE, (AHEAD, ASIDE, BEHIND, COLUMNS), flags, nearest, cell)
    ahead, left, away = points[0, ::_STRIDE, ::_STRIDE], points[1, ::_STRIDE, ::_STRIDE], spread[::_STRIDE, ::_STRIDE]
    seen = np.isfinite(away)
    reach = np.zeros(_N_BINS, np.float32)
    np.maximum.at(reach, _bins(ahead[seen], left[seen]), away[seen])
    distance, direction = _cells()
    explored = distance <= np.minimum(reach[direction] + 0.125, _CARVE_M)
    patch = flags.reshape(ROWS, COLUMNS)
    patch[explored] |= EXPLORED
    look = (255.0 * np.exp(-nearest / _LOOK_M)).astype(np.uint8).reshape(ROWS, COLUMNS)
    return patch, look, cell


def _chosen(found: Detections, shown: NDArray[np.bool_], target: str) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    """Rows and names of detected things in view: the target first, then by size.

    ``shown`` is by track: detectors may list boxes whose pixels all belong to others or have no valid depth.
    """
    seen = shown[found.track].tolist()
    things = [k for k, name in enumerate(found.category) if seen[k] and name not in STRUCTURE_KINDS]
    things.sort(key=lambda k: (found.category[k] != target, -int(found.pixels[k]), int(found.track[k])))
    rows = np.array(things[:N_THINGS], np.int64)
    return rows, tuple(found.category[k] for k in rows.tolist())


def _measure(image: NDArray[np.int16], points: F32, spread: F32, n: int, camera_m: float, out: F32) -> F32:
    """Write the features of n things into ``out`` from their pixels; returns their mean points (n, 3) in metres."""
    count, sums = np.zeros(n, np.int64), np.zeros((3, n))
    nearest, box = np.full(n, np.inf, np.float32), np.tile(np.array([1 << 20, -1, 1 << 20, -1]), (n, 1))
    measure(image, points, spread, count, sums, nearest, box)
    middle, here = np.full((n, 3), np.inf, np.float32), np.flatnonzero(count)
    mean = sums[:, here] / count[here]
    middle[here] = mean.T
    far = np.maximum(np.hypot(mean[0], mean[1]), 1e-3)
    height, width = image.shape
    u0, u1, v0, v1 = box[here].T
    out[here, 0], out[here, 1], out[here, 2] = mean[0], mean[1], mean[2] - camera_m
    out[here, 3], out[here, 4], out[here, 5] = nearest[here], mean[1] / far, mean[0] / far
    out[here, 6], out[here, 7], out[here, 8], out[here, 9] = (
        u0 / width, v0 / height, (u1 + 1) / width, (v1 + 1) / height,
    )  # fmt: skip
    out[here, 10] = np.log(count[here] * (16384 / image.size) / 64)
    return middle


def _pairs(
    image: NDArray[np.int16], cell: NDArray[np.int64], middle: F32
) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """(cell, thing) pairs: first the cell of each thing's mean point, then the cells of all its points."""
    with np.errstate(invalid="ignore"):
        f, left = (np.floor(middle[:, k] / CELL_M + 0.5) for k in range(2))
        inside = np.isfinite(f) & (f >= -BEHIND) & (f <= AHEAD) & (np.abs(left) <= ASIDE)
    rows = np.flatnonzero(inside)
    first = rows * N_CELLS + ((f[rows] + BEHIND) * COLUMNS + left[rows] + ASIDE).astype(np.int64)
    shown = np.zeros(len(middle) * N_CELLS, bool)
    mark_pairs(image, _STRIDE, cell, N_CELLS, shown)
    shown[first] = False
    keys = np.concatenate([first, np.flatnonzero(shown)])[:N_PAIRS]
    pair_cell, pair_row = np.full(N_PAIRS, -1, np.int16), np.full(N_PAIRS, -1, np.int16)
    pair_cell[: len(keys)], pair_row[: len(keys)] = keys % N_CELLS, keys // N_CELLS
    return pair_cell, pair_row
