"""Whether a relation holds, by boxes and the contacts that PyBullet reports.

The samplers test the settled pose; the unit tests test a live :class:`World` with the whole home.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from ucon.objects.model import Relation
from ucon.sim.house import STRUCTURE
from ucon.sim.placement.common import RUG_M
from ucon.sim.placement.inside import PROTRUDING_SHARE
from ucon.sim.placement.nextto import (
    BESIDE_FURNITURE_M,
    HANGING_M,
    gap_m,
    is_hanging,
    is_on_furniture,
    limit_m,
    reaches,
    under_rect,
    under_spaces,
)
from ucon.sim.placement.surroundings import COMPARTMENT, Surroundings
from ucon.sim.placement.tops import cover_of, floor_levels, tops
from ucon.sim.shapes import Array

LEVEL_M = 0.02
INSIDE_SHARE = 0.9
_SLACK_M = 0.006
_BESIDE_M = 0.05


def holds(scene: Surroundings, relation: Relation, anchor: int, box: Array, contacts: Collection[int]) -> bool:
    """Whether an object is in a relation to an anchor.

    Args:
        scene: the home and its arrangement.
        relation: the relation.
        anchor: instance.
        box: (6,) box of the object, metres.
        contacts: instances that it touches.
    """
    if relation == "ontop":
        return is_ontop(scene, anchor, box, contacts)
    if relation == "inside":
        return is_inside(scene, anchor, box)
    if relation == "under":
        return is_under(scene, anchor, box)
    return is_nextto(scene, anchor, box)


def is_ontop(scene: Surroundings, anchor: int, box: Array, contacts: Collection[int]) -> bool:
    """Whether the object touches the anchor, with its bottom at a surface's height and its centre above that surface.

    On the floor a rug may be in between; a slab that covers the anchor counts as its top.

    Args:
        scene: the home and its arrangement.
        anchor: instance.
        box: (6,) box of the object, metres.
        contacts: instances that it touches.
    """
    on_floor = scene.categories[anchor] in STRUCTURE
    middle = _middle(box)
    rows = floor_levels(scene, anchor) if on_floor else tops(scene, anchor)
    levels = np.array(rows).reshape(-1, 6)
    at_height = np.abs(levels[:, 2] - box[2]) <= (RUG_M if on_floor else LEVEL_M)
    above = ((levels[:, :2] <= middle + _SLACK_M) & (middle - _SLACK_M <= levels[:, 3:5])).all(axis=1)
    touched = on_floor or anchor in contacts or not cover_of(scene, anchor).isdisjoint(contacts)
    return bool((at_height & above).any()) and touched


def is_inside(scene: Surroundings, anchor: int, box: Array) -> bool:
    """Whether the object's centre and at least 90 % of its box are in one compartment of the anchor.

    60 % are enough if the compartment has no lid or door.

    Args:
        scene: the home and its arrangement.
        anchor: instance.
        box: (6,) box of the object, metres.
    """
    volume = max(float(np.prod(box[3:] - box[:3])), 1e-12)
    for row in scene.levels_of(anchor, COMPARTMENT):
        space = scene.levels.box[row] + np.array([-_SLACK_M] * 3 + [_SLACK_M] * 3)
        shared = float(np.prod(np.maximum(np.minimum(space[3:], box[3:]) - np.maximum(space[:3], box[:3]), 0.0)))
        least = INSIDE_SHARE if scene.levels.hides[row] else PROTRUDING_SHARE
        centre = (box[:3] + box[3:]) / 2
        within = bool(((space[:3] <= centre) & (centre <= space[3:])).all())
        if shared >= least * volume and within:
            return True
    return False


def is_under(scene: Surroundings, anchor: int, box: Array) -> bool:
    """Whether the centre of the object's footprint is below the anchor, and its top below the anchor's clearance.

    Args:
        scene: the home and its arrangement.
        anchor: instance.
        box: (6,) box of the object, metres.
    """
    middle, spaces = _middle(box), under_spaces(scene, anchor)
    if is_hanging(scene, anchor):
        own = scene.boxes[anchor]
        rect = under_rect(spaces, own)
        below = (rect[:2] - _SLACK_M <= middle) & (middle <= rect[2:] + _SLACK_M)
        return bool(below.all() and box[5] <= own[2] + _SLACK_M)
    for space in spaces:
        below = (space[:2] - _SLACK_M <= middle) & (middle <= space[3:5] + _SLACK_M)
        if below.all() and box[5] <= space[5] + _SLACK_M and box[2] >= space[2] - _SLACK_M:
            return True
    return False


def is_nextto(scene: Surroundings, anchor: int, box: Array) -> bool:
    """Whether the boxes overlap in height and are at most :func:`limit_m` apart.

    Wall items are next to what is below them; tall things on the floor are next to what stands on the furniture beside
    them.

    Args:
        scene: the home and its arrangement.
        anchor: instance.
        box: (6,) box of the object, metres.
    """
    if scene.categories[anchor] == "walls":
        boxes = scene.parts.boxes[scene.parts.owner == anchor]
        return bool(gap_m(boxes, box).min() <= 0.10)
    own = scene.boxes[anchor]
    gap = float(gap_m(own, box))
    if is_hanging(scene, anchor):
        return gap <= HANGING_M + 0.1 and bool(box[2] < own[5])
    if is_on_furniture(scene, anchor) and box[2] < RUG_M and reaches(float(box[5] - box[2]), own):
        return gap <= BESIDE_FURNITURE_M + _SLACK_M
    beside = bool(box[2] <= own[5] + _BESIDE_M and box[5] >= own[2] - _BESIDE_M)
    overlapping = gap <= 0.0 and bool((np.minimum(own[3:], box[3:]) - np.maximum(own[:3], box[:3]) > 0.02).all())
    return beside and gap <= limit_m(own, box) + _SLACK_M and not overlapping


def _middle(box: Array) -> Array:
    return (box[:2] + box[3:5]) / 2
