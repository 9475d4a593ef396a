"""Kernels of looking with a detector that errs: a look may miss a target, and looks that err together count once.

They are the counterparts of :func:`ucon.perception.mapping.map_kernels.look` and of ``place_gain`` and ``fade_places``
in :mod:`ucon.perception.views.view_kernels`, in which every look counts the same.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ucon.core.jit import F32, F64, I32, U8, Flags, jit, merged
from ucon.perception.hypotheses.look_kernels import look_key
from ucon.perception.mapping.map_kernels import CELL_M, shows
from ucon.perception.views.view_kernels import add_to_views, between, in_sight, in_view, sight

#: Chances are given for distances in steps of this many metres, from 0 on.
STEP_M = 0.25


@merged
def _chance(away_m: float, chance: F64) -> float:
    """The chance that a look from ``away_m`` metres shows the target, from the chances (k,) by distance."""
    return chance[min(int(away_m / STEP_M + 0.5), chance.shape[0] - 1)]


@jit
def look_by_chance(
    depth: F32, camera: F64, model: Any, places: F64, hollow: F64, faces: U8, active: Flags, unseen: F64, looked: Any
) -> int:
    """Lower ``unseen`` of the sample points that a frame shows from a new side or distance, by the chance of each look.

    Args:
        depth: (H, W) float32, metres along the optical axis.
        camera: (8,) float64.
        model: chances (k,) at every ``STEP_M``; sides and limits of :func:`look_key`.
        places: (n, 3) float64, the points, metres.
        hollow: (n, 6) float64, boxes of their compartments, metres.
        faces: (n,) uint8, bits of the compartments' open sides.
        active: (n,) bool, points to look at.
        unseen: (n,) float64, updated.
        looked: (n,) uint64, updated: bits of the sides and distances from which each was looked at.

    Returns:
        How many points are shown from a new side or distance.
    """
    chance, sides, limits_m2 = model
    rows, columns = depth.shape
    x, y, cam_z, c, s, cp, sp, focal_px = camera
    shown = 0
    for n in range(places.shape[0]):
        if not active[n]:
            continue
        dx, dy, dz = places[n, 0] - x, places[n, 1] - y, places[n, 2] - cam_z
        flat, right = c * dx + s * dy, s * dx - c * dy
        optical, up = cp * flat + sp * dz, cp * dz - sp * flat
        if optical <= 0.15 or optical > STEP_M * chance.shape[0]:
            continue
        u = int(np.floor(0.5 * columns + focal_px * right / optical))
        v = int(np.floor(0.5 * rows - focal_px * up / optical))
        if not (0 <= u < columns and 0 <= v < rows and depth[v, u] > optical - 0.05):
            continue
        bit = np.uint64(1) << np.uint64(look_key(dx, dy, dz, sides, limits_m2))
        if looked[n] & bit:
            continue
        if shows(x, y, cam_z, places[n, 0], places[n, 1], places[n, 2], hollow[n], faces[n]):
            looked[n] |= bit
            unseen[n] *= 1.0 - _chance(np.sqrt(dx * dx + dy * dy + dz * dz), chance)
            shown += 1
    return shown


@jit
def gain_by_chance(
    nodes: I32, rows: I32, place: F64, hollow: F64, faces: U8, weight: F64, hidden: Any, looked: Any, model: Any,
    cam_z: float, height: F32, walls: U8, half: int, out: F64,
) -> None:  # fmt: skip
    """Add the weight of the sample points that each view would show, times the chance that it shows a target there.

    Args:
        nodes: (n, 2) int32, sorted by i.
        rows: (k,) int32, the points that count.
        place: (m, 3) float64, the points, metres.
        hollow: (m, 6) float64, boxes of their compartments, metres.
        faces: (m,) uint8, bits of the compartments' open sides.
        weight: (m,) float64.
        hidden: (m, WORDS) uint64, updated; see :func:`ucon.perception.views.view_kernels.in_sight`.
        looked: (m,) uint64, bits of the sides and distances from which each was looked at.
        model: as in :func:`look_by_chance`.
        cam_z: height of the camera, metres.
        height: (c, c) float32, metres.
        walls: (2, c, c) uint8.
        half: cell number of the start.
        out: (n, H, 4) float64, updated: node, heading, pitch.
    """
    chance, sides, limits_m2 = model
    reach_m = STEP_M * chance.shape[0]
    span = int(reach_m / CELL_M) + 1
    for m in rows:
        w = weight[m]
        px, py, pz = place[m]
        middle = int(np.floor(px / CELL_M + 0.5)) + half
        first, last = between(nodes, middle - span, middle + span)
        for n in range(first, last):
            i, j = nodes[n]
            dx, dy, dz = px - (i - half) * CELL_M, py - (j - half) * CELL_M, pz - cam_z
            away_m2 = dx * dx + dy * dy + dz * dz
            if away_m2 > reach_m * reach_m:
                continue
            if looked[m] >> np.uint64(look_key(dx, dy, dz, sides, limits_m2)) & np.uint64(1):
                continue
            if not in_sight(m, i, j, cam_z, place, hollow, faces, hidden, height, walls, half):
                continue
            add_to_views(dx, dy, dz, w * _chance(np.sqrt(away_m2), chance), reach_m, out[n])


@jit
def fade_by_chance(
    x: float, y: float, cam_z: float, looks: tuple[int, int, int], place: F64, hollow: F64, faces: U8, weight: F64,
    model: Any, height: F32, walls: U8, half: int, unseen: F64, looked: Any, factor: float,
) -> None:  # fmt: skip
    """Multiply ``unseen`` of the points that a view was expected to show and evidently did not.

    They are marked as looked at from there.

    Args:
        x: of the camera, metres.
        y: of the camera, metres.
        cam_z: of the camera, metres.
        looks: heading, number of headings, and number of the pitch in ``PITCHES_DEG``.
        place: (m, 3) float64, the points, metres.
        hollow: (m, 6) float64, boxes of their compartments, metres.
        faces: (m,) uint8, bits of the compartments' open sides.
        weight: (m,) float64; points of weight 0 are left alone.
        model: as in :func:`look_by_chance`.
        height: (c, c) float32, metres.
        walls: (2, c, c) uint8.
        half: cell number of the start.
        unseen: (m,) float64, updated.
        looked: (m,) uint64, updated.
        factor: multiplies ``unseen``.
    """
    chance, sides, limits_m2 = model
    reach_m = STEP_M * chance.shape[0]
    heading, n, pitch = looks
    for m in range(place.shape[0]):
        if weight[m] <= 0.0:
            continue
        px, py, pz = place[m]
        dx, dy, dz = px - x, py - y, pz - cam_z
        if dx * dx + dy * dy + dz * dz > reach_m * reach_m:
            continue
        if not shows(x, y, cam_z, px, py, pz, hollow[m], faces[m]):
            continue
        if not sight(x, y, cam_z, px, py, pz, height, walls, half):
            continue
        bit = np.uint64(1) << np.uint64(look_key(dx, dy, dz, sides, limits_m2))
        if in_view(dx, dy, dz, heading, n, pitch, reach_m) and looked[m] & bit == 0:
            looked[m] |= bit
            unseen[m] *= factor
