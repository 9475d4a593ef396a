"""Cuts the openings into the walls that joined rooms share."""

from __future__ import annotations

from ucon.core.errors import SceneError
from ucon.core.rng import stream
from ucon.scenes.layout import GAP_CELLS
from ucon.scenes.spec import GRID_M, LINTEL_M, Opening
from ucon.scenes.tidy import FloorPlan, Rect, shared_wall

CORNER_CELLS = 2
"""Distance of openings from room corners in cells (0.5 m), where the wall is long enough."""


def cut_openings(plan: FloorPlan, seed: int, wall_height_m: float) -> tuple[Opening, ...]:
    """An opening for every edge of a plan, in the order of the edges.

    Args:
        plan: the floor plan.
        seed: of the positions.
        wall_height_m: of the home.
    """
    found = []
    for a, b, joint in plan.edges:
        wall = shared_wall(plan.rect(a), plan.rect(b))
        if wall is None:
            raise SceneError(f"no wall between {a} and {b}")
        axis, coord, low, high = wall
        width = high - low if joint == "open" else min(GAP_CELLS[joint], high - low)
        if joint == "open" and not b.endswith("_b"):
            width = max(4, high - low - 2)  # leave ends of the wall, so that two rooms can be told apart
        start = _start(plan.rect(a), plan.rect(b), wall, width, joint, stream(seed, "opening", a, b).random())
        lo, hi = start * GRID_M, (start + width) * GRID_M
        height = wall_height_m if joint == "open" else LINTEL_M
        rooms = plan.names.index(a), plan.names.index(b)
        found.append(Opening(0 if axis == 0 else 1, coord * GRID_M, lo, hi, rooms[0], rooms[1], height))
    return tuple(found)


def _start(a: Rect, b: Rect, wall: tuple[int, int, int, int], width: int, joint: str, draw: float) -> int:
    axis, _, low, high = wall
    for margin in (CORNER_CELLS, 1, 0):
        first = max(low, a[1 - axis] + margin, b[1 - axis] + margin)
        last = min(high, a[3 - axis] - margin, b[3 - axis] - margin) - width
        if last >= first:
            break
    else:
        return low
    if joint != "doorway":
        return (first + last) // 2
    # Doors stand near a corner, so that a long piece of wall is left for furniture.
    return first if draw < 0.45 else last if draw < 0.9 else (first + last) // 2
