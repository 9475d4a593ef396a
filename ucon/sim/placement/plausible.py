"""Whether a placement is possible at all, by the shapes of its two categories and without a home.

The criteria are those of the samplers: what is refused here, :func:`ucon.sim.placement.place` refuses for every anchor
of that size, or nobody would carry it there. What is not refused may still find no free place in a home.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Category, ObjectModel, Relation, Vec3
from ucon.sim.house import STRUCTURE
from ucon.sim.placement import inside, ontop, under
from ucon.sim.placement.reasons import Reason
from ucon.sim.placement.slots import SlotPose, poses
from ucon.sim.shapes import solid

#: A reason (a key, for counting) and a message.
Refusal = tuple[Reason, str]

_OFF_THE_FLOOR_M = 0.25
_ANYWHERE_M = 1e3
_HUNG = frozenset(
    (
        *("curtain", "electric_switch", "fire_extinguisher", "hanging_basket", "hanging_plant", "hook", "mirror"),
        *("painting", "picture", "poster", "valentine_wreath", "wall_clock", "wall_mounted_light", "window_blind"),
    )
)
"""Categories that hang on a nail, and that people therefore move."""


@lru_cache(maxsize=65536)
def implausible(category: str, relation: Relation, anchor: str, size: Vec3 | None = None) -> Refusal | None:
    """Why a placement is impossible.

    Args:
        category: of the object.
        relation: ``ontop``, ``inside``, ``under`` or ``nextto``.
        anchor: category of the anchor.
        size: of the anchor in a home; None: the catalogue's.

    Returns:
        Reason and message; None where nothing forbids it.

    Raises:
        ConfigError: one of the two is not in the catalogue.
    """
    row, other = catalogue()[category], catalogue()[anchor]
    if row.role not in ("movable", "movable_furniture") and category not in _HUNG:
        return "implausible", f"{category} is fixed and cannot be moved"
    if anchor in STRUCTURE:
        return _by_structure(relation, anchor)
    model = solid(anchor, size).model
    if relation == "ontop":
        return _ontop(row, model)
    if relation == "inside":
        return _inside(row, model)
    return _under(row, model, other) if relation == "under" else None


def _by_structure(relation: Relation, anchor: str) -> Refusal | None:
    if (relation, anchor) in (("ontop", "floors"), ("nextto", "walls")):
        return None
    return "implausible", f"nothing is {relation} {anchor}"


def _ontop(row: Category, anchor: ObjectModel) -> Refusal | None:
    if not anchor.surfaces:
        return "not_a_support", f"{anchor.category} has no level surface on top"
    levels = [np.array([s.x0, s.y0, s.z, s.x1, s.y1, s.z + s.clearance_m]) for s in anchor.surfaces]
    if any(ontop.fits(level, pose) for level in levels for pose in _poses(row, lay=False)):
        return None
    return "too_large", f"{row.name} is larger than the top of {anchor.category}"


def _inside(row: Category, anchor: ObjectModel) -> Refusal | None:
    if not anchor.compartments:
        return "not_a_container", f"{anchor.category} has no space inside"
    for space in anchor.compartments:
        box, open_top = np.array(space.box), not space.opened_by and space.link < 0
        if any(inside.fits(box, pose, open_top) for pose in _poses(row, lay=True)):
            return None
    return "too_large", f"{row.name} does not fit into {anchor.category}"


def _under(row: Category, anchor: ObjectModel, other: Category) -> Refusal | None:
    spaces = [np.array(space) for space in anchor.under]
    if other.mount in ("wall", "ceiling") and other.bottom_z_m > _OFF_THE_FLOOR_M:
        spaces.append(np.array([-_ANYWHERE_M, -_ANYWHERE_M, 0.0, _ANYWHERE_M, _ANYWHERE_M, other.bottom_z_m]))
    if not spaces:
        return "no_room_under", f"there is no space under {anchor.category}"
    if any(under.fits(space, pose) for space in spaces for pose in _poses(row, lay=True)):
        return None
    return "too_large", f"{row.name} is too large for the space under {anchor.category}"


def _poses(row: Category, *, lay: bool) -> list[SlotPose]:
    return poses(solid(row.name), lay=lay)
