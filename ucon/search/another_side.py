"""Views of a thing from a new side or distance, from which the detector does not repeat its earlier errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import heading_to
from ucon.perception.hypotheses.look_kernels import NEVER
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SIZE, SemanticMap, View, camera_of
from ucon.perception.views.view_kernels import sight

#: A new side is looked for within this many cells of the thing, and this many actions of the agent.
_CELLS, _MOST_COST = 9, 12
#: A view must be at least this far from the thing, metres, and show it at most this share of the field of view above or
#: below the camera's axis.
_LEAST_M, _ASIDE = 0.2, 38.0 / 90.0
#: A surface nearer than a thing by more than this hides it, metres.
_HIDES_M = 0.1
#: Share of the rectangle of its two longer sides that a thing shows, since it may be turned or round.
_SHOWN = 0.5


def another_side(known: SemanticMap, planner: Planner, track: int) -> View | None:
    """The cheapest view of a thing from a side and distance from which it was not seen.

    Args:
        known: the map.
        planner: updated here.
        track: the thing.

    Returns:
        None where there is none nearby.
    """
    planner.update(known)
    x, y, _ = _middle(known, track)
    ci, cj = round(x / CELL_M) + HALF, round(y / CELL_M) + HALF
    best, lowest = None, _MOST_COST + 1
    for i in range(max(ci - _CELLS, 0), min(ci + _CELLS + 1, SIZE)):
        for j in range(max(cj - _CELLS, 0), min(cj + _CELLS + 1, SIZE)):
            if planner.steps[i, j].min() >= lowest or not known.explored[i, j]:
                continue
            for view, cost in _facing(known, planner, track, i, j):
                if cost < lowest and _is_new(known, track, view):
                    best, lowest = view, cost
    return best


def _facing(known: SemanticMap, planner: Planner, track: int, i: int, j: int) -> list[tuple[View, int]]:
    """Views from a node that have a thing in the picture, and their costs in actions."""
    x, y, z = _middle(known, track)
    dx, dy = x - (i - HALF) * CELL_M, y - (j - HALF) * CELL_M
    flat = float(np.hypot(dx, dy))
    if flat < _LEAST_M:
        return []
    heading = heading_to(dx, dy, known.body.headings)
    steps, now = int(planner.steps[i, j, heading]), known.view.pitch_deg
    return [
        (View(i, j, heading, look), steps + abs(look - now) // 30)
        for look, (eye_m, pitch) in known.body.eyes.items()
        if abs(np.rad2deg(np.arctan2(z - eye_m, flat)) - pitch) <= _ASIDE * known.body.fov_deg
    ]


def _is_new(known: SemanticMap, track: int, view: View) -> bool:
    """Whether a view shows a thing from a new side or distance, with nothing known in between."""
    assert known.hypotheses is not None
    x, y, z = _middle(known, track)
    at_x, at_y = view.xy
    eye_m = known.body.eyes[view.pitch_deg][0]
    if known.hypotheses.state_from(track, x - at_x, y - at_y, z - eye_m) != NEVER:
        return False
    return bool(sight(at_x, at_y, eye_m, x, y, z, known.height, known.walls, HALF))


def in_view(known: SemanticMap, depth: NDArray[np.float32], track: int) -> bool:
    """Whether the middle of a thing is in the image, nothing nearer hides it, and it is near enough to be seen.

    Whether it is near enough is checked only on maps that are kept, where boxes are no larger than things.

    Args:
        known: the map, updated with the frame.
        depth: (H, W) float32 of the frame, metres.
        track: the thing.
    """
    x, y, z, c, s, cp, sp, focal_px = camera_of(known.view, depth, known.body).tolist()
    px, py, pz = _middle(known, track)
    dx, dy, dz = px - x, py - y, pz - z
    ahead, right = c * dx + s * dy, s * dx - c * dy
    optical, up = cp * ahead + sp * dz, cp * dz - sp * ahead
    if optical < _HIDES_M:
        return False
    rows, columns = depth.shape
    u, v = int(0.5 * columns + focal_px * right / optical), int(0.5 * rows - focal_px * up / optical)
    if not (0 <= u < columns and 0 <= v < rows):
        return False
    sides = np.sort(known.box[track, 3:] - known.box[track, :3])
    if known.looks is not None and _SHOWN * sides[1] * sides[2] * (focal_px / optical) ** 2 < MIN_PIXELS:
        return False
    return bool(depth[v, u] >= optical - 0.5 * sides[2] - _HIDES_M)


def _middle(known: SemanticMap, track: int) -> tuple[float, float, float]:
    """Middle (x, y, z) of the box of a thing, metres."""
    box = known.box[track]
    x, y, z = (0.5 * (box[:3] + box[3:])).tolist()
    return x, y, z
