"""``nextto``: slots on the anchor's level, else on what stands beside it, else on the floor.

Two things are next to each other if their boxes overlap in height and are at most :func:`limit_m` apart seen from
above. For things that hang on a wall (mirror, picture, wall TV), what is below them is "next to" them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ucon.sim.house import STRUCTURE
from ucon.sim.placement.common import PlacementRequest, depth_penalty, ordered
from ucon.sim.placement.kernels import ring
from ucon.sim.placement.reasons import RefusedError
from ucon.sim.placement.slots import Slot, SlotPose, poses
from ucon.sim.placement.surroundings import COMPARTMENT, FLOOR_LEVEL, SURFACE, Surroundings, turned_box
from ucon.sim.placement.tops import cover_row
from ucon.sim.shapes import Array

GAPS_M = (0.02, 0.05, 0.08)
FAR_GAPS_M = (0.12, 0.18, 0.25)
HANGING_M = 0.45
"""Horizontal reach of "next to" for what hangs on a wall, metres."""
BESIDE_FURNITURE_M = 0.60
"""Reach of "next to" for tall things on the floor beside the furniture that the anchor stands on."""
_SAME_LEVEL_M = 0.03
UNDER_HANGING_M = 0.35
_PER_STAGE = 10
_RING_STEP_M = 0.06
_RING_MOST = 30
_DOORWAY_M = 0.5


def limit_m(a: Array, b: Array) -> float:
    """Largest gap at which two boxes are next to each other.

    Args:
        a: (6,) metres.
        b: (6,) metres.

    Returns:
        A sixth of the sum of their mean edges, clipped to 0.10 to 0.30 m.
    """
    mean_edges = float((a[3:] - a[:3]).mean() + (b[3:] - b[:3]).mean())
    return float(np.clip(mean_edges / 6, 0.10, 0.30))


def gap_m(a: Array, b: Array) -> Array:
    """Horizontal distance between boxes (..., 6), metres."""
    delta = np.maximum(np.maximum(a[..., :2] - b[..., 3:5], b[..., :2] - a[..., 3:5]), 0.0)
    return np.hypot(delta[..., 0], delta[..., 1])


def is_hanging(scene: Surroundings, anchor: int) -> bool:
    """Whether an instance hangs on a wall or ceiling, off the floor."""
    return scene.mount(anchor) in ("wall", "ceiling") and scene.boxes[anchor][2] > 0.25


def candidates(request: PlacementRequest) -> Iterator[Slot]:
    """Slots next to the anchor, the best first.

    Raises:
        RefusedError: nothing can be next to a floor or a ceiling.
    """
    if request.anchor_name == "walls":
        return _along_walls(request)
    if request.anchor_name in STRUCTURE:
        raise RefusedError("implausible", f"nothing is next to {request.anchor_name}")
    if is_hanging(request.scene, request.anchor) and not _stands_on_level(request):
        return below_hanging(request, under_rect([], request.anchor_box), ceiling_m=float(request.anchor_box[5]) + 1.0)
    return _beside(request)


def under_spaces(scene: Surroundings, anchor: int) -> list[Array]:
    """World boxes (6,) of the free spaces below an instance."""
    standing = scene.standing[anchor]
    return [turned_box(np.array(space), standing) for space in standing.shape.model.under]


def under_rect(spaces: list[Array], box: Array) -> Array:
    """The rectangle on the floor that counts as under, or next to, something that hangs.

    Args:
        spaces: boxes (6,) of the spaces below it.
        box: (6,) of the thing, metres.

    Returns:
        (4,) x0, y0, x1, y1.
    """
    rect = box[[0, 1, 3, 4]] + np.array([-1, -1, 1, 1]) * (UNDER_HANGING_M if spaces else HANGING_M)
    for space in spaces:
        rect[:2], rect[2:] = np.minimum(rect[:2], space[:2]), np.maximum(rect[2:], space[3:5])
    return rect


def below_hanging(request: PlacementRequest, rect: Array, ceiling_m: float) -> Iterator[Slot]:
    """Slots below what hangs on a wall: on the highest level first, then lower ones, then the floor.

    Args:
        request: the request.
        rect: (4,) of :func:`under_rect`.
        ceiling_m: greatest height of the object's top.
    """
    scene, box = request.scene, request.anchor_box
    reach = np.array([rect[0], rect[1], 0.0, rect[2], rect[3], 0.0])
    rows = [
        r
        for r in _rows_near(scene, reach)
        if scene.levels.box[r, 2] < min(box[5], ceiling_m) and not scene.levels.hides[r]
    ]
    rows.sort(key=lambda r: (scene.levels.kind[r] == FLOOR_LEVEL, -scene.levels.box[r, 2]))
    if request.row.mount == "floor":
        rows = [r for r in rows if scene.levels.kind[r] == FLOOR_LEVEL]
    for row in rows:
        level = scene.levels.box[row]
        stand = bool(scene.levels.kind[row] == FLOOR_LEVEL)
        for pose in poses(request.shape, lay=False, stand=stand):
            if level[2] + pose.extent[2] > min(level[5], ceiling_m):
                continue
            centres = _lattice(rect)
            centres = centres[_on_level(level, centres, pose)]
            away = gap_m(_footprints(centres, pose), box)
            yield from ordered(request, centres, level[2], pose, 3.0 * away, keep=_PER_STAGE)


def _beside(request: PlacementRequest) -> Iterator[Slot]:
    scene, box = request.scene, request.anchor_box
    reach = box + np.array([-0.4, -0.4, 0, 0.4, 0.4, 0])
    near = [r for r in _rows_near(scene, reach) if scene.levels.owner[r] != request.anchor]
    for stage in _stages(request, near):
        for gaps in (GAPS_M, FAR_GAPS_M):
            on_floor = all(scene.levels.kind[row] == FLOOR_LEVEL for row in stage)
            for pose in poses(request.shape, lay=False, stand=on_floor):
                for row in stage:
                    yield from _ring(request, row, pose, gaps)
    if is_on_furniture(scene, request.anchor) and reaches(request.shape.extent[2], box):
        yield from _beside_furniture(request)


def is_on_furniture(scene: Surroundings, anchor: int) -> bool:
    """Whether an instance stands on something rather than on the floor."""
    return bool(scene.boxes[anchor][2] > 0.25)


def reaches(height_m: float, box: Array) -> bool:
    """Whether a thing on the floor is tall enough to be next to something on the furniture beside it.

    Args:
        height_m: of the thing on the floor.
        box: (6,) of the other, metres.
    """
    return height_m >= box[2] - 0.25


def _beside_furniture(request: PlacementRequest) -> Iterator[Slot]:
    """Slots on the floor for tall things: a floor lamp next to the lamp on a table, a stool next to a glass."""
    scene, box = request.scene, request.anchor_box
    reach = box + np.array([-BESIDE_FURNITURE_M, -BESIDE_FURNITURE_M, 0, BESIDE_FURNITURE_M, BESIDE_FURNITURE_M, 0])
    rows = [r for r in _rows_near(scene, reach) if scene.levels.kind[r] == FLOOR_LEVEL]
    tall = [pose for pose in poses(request.shape, lay=False, stand=True) if reaches(pose.extent[2], box)]
    for pose in tall:
        for row in rows:
            level = scene.levels.box[row]
            half = pose.extent[:2] / 2
            centres = _lattice(reach[[0, 1, 3, 4]] + np.concatenate([-half, half]))
            away = gap_m(_footprints(centres, pose), box)
            keep = _on_level(level, centres, pose) & (away <= BESIDE_FURNITURE_M)
            penalty = 4.0 * away[keep] + 10.0 * _in_doorway(scene, centres[keep], pose)
            yield from ordered(request, centres[keep], 0.0, pose, penalty, keep=_PER_STAGE)


def _stages(request: PlacementRequest, near: list[int]) -> list[list[int]]:
    """Levels to try in order: the anchor's own, the tops of its neighbours, the floor."""
    levels, box = request.scene.levels, request.anchor_box
    z, kind = levels.box[:, 2], levels.kind
    middle = (box[:3] + box[3:]) / 2
    same = [r for r in near if abs(z[r] - box[2]) <= _SAME_LEVEL_M and kind[r] != FLOOR_LEVEL]
    same = [r for r in same if kind[r] != COMPARTMENT or _contains(levels.box[r], middle)]
    if is_hidden(request.scene, request.anchor):
        return [same]
    tops = [r for r in near if box[2] + 0.3 <= z[r] <= box[5] + 0.05 and kind[r] == SURFACE]
    floor = [r for r in near if kind[r] == FLOOR_LEVEL]
    if request.row.mount == "floor":
        return [floor, same] if box[2] < 0.3 else [same]
    if box[2] > 0.3:
        return [same, tops]
    return [same, tops, floor]


def is_hidden(scene: Surroundings, instance: int) -> bool:
    """Whether an instance is inside a container that must be opened."""
    box = scene.boxes[instance]
    return scene.holder_at((box[:3] + box[3:]) / 2, but=instance)[0] >= 0


def _contains(box: Array, point: Array) -> bool:
    return bool((box[:3] <= point).all() and (point <= box[3:]).all())


def _stands_on_level(request: PlacementRequest) -> bool:
    levels, box = request.scene.levels, request.anchor_box
    middle = (box[:2] + box[3:5]) / 2
    inside = (levels.box[:, :2] <= middle).all(axis=1) & (middle <= levels.box[:, 3:5]).all(axis=1)
    others = levels.owner != request.anchor
    return bool((inside & others & (np.abs(levels.box[:, 2] - box[2]) <= _SAME_LEVEL_M)).any())


def _ring(request: PlacementRequest, row: int, pose: SlotPose, gaps: tuple[float, ...]) -> Iterator[Slot]:
    """Slots around the anchor on one level, at the given gaps."""
    scene, box = request.scene, request.anchor_box
    level = scene.levels.box[row]
    if pose.extent[2] > level[5] - level[2]:
        return
    centres = ring(box, pose.extent[0] / 2, pose.extent[1] / 2, np.array(gaps), _RING_STEP_M, _RING_MOST)
    full = np.concatenate([np.zeros(2), [level[2]], pose.extent[:2], [level[2] + pose.extent[2]]])
    near = gap_m(_footprints(centres, pose), box) <= limit_m(full, box)
    centres = centres[near & _on_level(level, centres, pose)]
    penalty = np.asarray(depth_penalty(request, centres, level[2]))
    if scene.levels.kind[row] == FLOOR_LEVEL and len(centres):
        penalty = np.asarray(penalty + 10.0 * _in_doorway(scene, centres, pose), np.float64)
    yield from ordered(request, centres, level[2], pose, penalty, keep=_PER_STAGE)


def _along_walls(request: PlacementRequest) -> Iterator[Slot]:
    """Slots on the floor along the walls of the anchor's room."""
    scene = request.scene
    row = next(r for r in np.flatnonzero(scene.levels.kind == FLOOR_LEVEL) if scene.levels.number[r] == _room(request))
    level = scene.levels.box[row]
    for pose in poses(request.shape, lay=False, stand=True):
        half = pose.extent[:2] / 2 + 0.02
        low, high = level[:2] + half, level[3:5] - half
        if (high <= low).any():
            continue
        xs, ys = np.arange(low[0], high[0], 0.1), np.arange(low[1], high[1], 0.1)
        sides = [np.stack([xs, np.full_like(xs, y)], 1) for y in (low[1], high[1])]
        sides += [np.stack([np.full_like(ys, x), ys], 1) for x in (low[0], high[0])]
        centres = np.concatenate(sides)
        yield from ordered(
            request, centres, 0.0, pose, _in_doorway(scene, centres, pose) * np.float64(10.0), keep=_PER_STAGE
        )


def _room(request: PlacementRequest) -> int:
    return (request.anchor - request.scene.house.n_items) // len(STRUCTURE)


def _rows_near(scene: Surroundings, reach: Array) -> list[int]:
    b = scene.levels.box
    meets = (b[:, :2] < reach[3:5]).all(axis=1) & (b[:, 3:5] > reach[:2]).all(axis=1)
    rows = [int(r) for r in np.flatnonzero(meets)]
    return [r for r in rows if scene.levels.kind[r] != SURFACE or cover_row(scene, r) is None]


def _on_level(level: Array, centres: Array, pose: SlotPose) -> NDArray[np.bool_]:
    """Whether footprints rest on a level; up to a fifth of the length may project over each edge."""
    half = 0.3 * pose.extent[:2]
    return np.asarray(np.all((centres - half >= level[:2]) & (centres + half <= level[3:5]), axis=1))


def _footprints(centres: Array, pose: SlotPose) -> Array:
    """Boxes (n, 6) of footprints, without height."""
    half = np.append(pose.extent[:2] / 2, 0.0)
    middle = np.concatenate([centres, np.zeros((len(centres), 1))], axis=1)
    return np.concatenate([middle - half, middle + half], axis=1)


def _lattice(rect: Array) -> Array:
    axes = [np.linspace(rect[a], rect[2 + a], int(np.clip((rect[2 + a] - rect[a]) / 0.05 + 1, 3, 30))) for a in (0, 1)]
    x, y = np.meshgrid(*axes, indexing="ij")
    return np.stack([x.ravel(), y.ravel()], axis=1)


def _in_doorway(scene: Surroundings, centres: Array, pose: SlotPose) -> NDArray[np.bool_]:
    """Whether footprints at centres (n, 2) stand in the way through an opening."""
    found = np.zeros(len(centres), bool)
    half = pose.extent[:2] / 2
    for opening in scene.house.spec.openings:
        across, along = centres[:, opening.axis], centres[:, 1 - opening.axis]
        near = np.abs(across - opening.coord) < _DOORWAY_M + half[opening.axis]
        reach = half[1 - opening.axis]
        found |= near & (along + reach > opening.lo) & (along - reach < opening.hi)
    return found
