"""``inside``: slots on the floor of the anchor's compartments, with the object turned or laid so that it fits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ucon.sim.placement.common import PlacementRequest, alternate, depth_penalty, ordered
from ucon.sim.placement.reasons import RefusedError
from ucon.sim.placement.slots import Slot, SlotPose, centres_in, is_long, poses
from ucon.sim.placement.surroundings import COMPARTMENT
from ucon.sim.shapes import Array

AIR_M = 0.004
"""Free height kept above an object in a closed compartment."""
PROTRUDING_SHARE = 0.6
"""An open compartment (basket, bowl, shelf) must hold at least this share of the object's height."""
_PER_SPACE = 6
_WALL_M = 0.002
_LOOK_DOWN_M = 1.0


def candidates(request: PlacementRequest) -> Iterator[Slot]:
    """Slots inside the anchor, the best first.

    Raises:
        RefusedError: it has no compartment, or the object fits into none of them.
    """
    scene = request.scene
    rows = scene.levels_of(request.anchor, COMPARTMENT)
    if not len(rows):
        raise RefusedError("not_a_container", f"{request.anchor_name} has no space inside")
    stages: list[list[tuple[Array, SlotPose]]] = [[], []]
    for row in rows:
        level, open_top = scene.levels.box[row], not scene.levels.hides[row]
        for pose in poses(request.shape, lay=True):
            if fits(level, pose, open_top):
                stages[_awkward(request, pose)].append((level, pose))
    if not any(stages):
        raise RefusedError("too_large", f"{request.category} does not fit into {request.anchor_name}")
    return _slots(request, stages)


def fits(level: Array, pose: SlotPose, open_top: bool) -> bool:
    """Whether an object in a pose fits into an empty compartment.

    Args:
        level: (6,) box of the compartment, metres.
        pose: orientation of the object.
        open_top: whether the object may stick out at the top.
    """
    room = level[3:] - level[:3]
    height = pose.extent[2] * PROTRUDING_SHARE if open_top else pose.extent[2] + AIR_M
    return bool((pose.extent[:2] <= room[:2] - 2 * _WALL_M).all() and height <= room[2])


def _awkward(request: PlacementRequest, pose: SlotPose) -> int:
    """1 if the object lies on its side although it could stand."""
    upright = pose.turn[2, 2] > 0.5
    return int(not upright and not is_long(request.shape.extent))


def _slots(request: PlacementRequest, stages: list[list[tuple[Array, SlotPose]]]) -> Iterator[Slot]:
    for stage in stages:
        shuffled = [stage[k] for k in request.rng.permutation(len(stage))]
        yield from alternate([_in_space(request, level, pose) for level, pose in shuffled])


def _seen_from_above(request: PlacementRequest, level: Array) -> bool:
    """Whether nothing but the anchor's own lid or handle is above a compartment, and it is low enough to look into."""
    if level[5] > _LOOK_DOWN_M:
        return False
    middle = (level[:2] + level[3:5]) / 2
    above = np.concatenate([middle - 0.03, [level[5]], middle + 0.03, [level[5] + 0.3]])
    rows = request.scene.parts_near(above)
    shape = request.scene.standing[request.anchor].shape
    fixed = [r for r in rows if request.scene.parts.owner[r] == request.anchor]
    return all(shape.link[request.scene.parts.number[r]] >= 0 or _is_thin(request, r) for r in fixed)


def _is_thin(request: PlacementRequest, row: int) -> bool:
    box = request.scene.parts.boxes[row]
    return bool(min(box[3] - box[0], box[4] - box[1]) < 0.06)


def _in_space(request: PlacementRequest, level: Array, pose: SlotPose) -> Iterator[Slot]:
    rect = level[[0, 1, 3, 4]] + np.array([_WALL_M, _WALL_M, -_WALL_M, -_WALL_M])
    centres = centres_in(rect, pose.extent)
    penalty = 2.0 * np.asarray(depth_penalty(request, centres, level[2]))
    if _seen_from_above(request, level) and len(centres):
        # The near wall of a basket or chest hides what stands close behind it.
        penalty = 4.0 * np.hypot(*(centres - (level[:2] + level[3:5]) / 2).T)
    return ordered(request, centres, level[2], pose, penalty, keep=_PER_SPACE)
