"""Spots: the part or side of an anchor that an object is put at, such as the foot of the bed or behind the laptop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ucon.objects.model import Relation
from ucon.sim.placement.slots import SlotPose
from ucon.sim.placement.surroundings import SURFACE, Surroundings
from ucon.sim.shapes import Array

Side = Literal["front", "behind", "left", "right"]
SIDES: Final[tuple[Side, ...]] = get_args(Side)
#: Direction of each side in the anchor's frame, whose +x is its front. Left and right are as seen by
#: someone who stands in front of it. The foot of a bed is its front, as its head is at the wall.
_AHEAD_LEFT: Final = {"front": (1.0, 0.0), "behind": (-1.0, 0.0), "left": (0.0, -1.0), "right": (0.0, 1.0)}
#: A side of a top begins at this fraction of the way from its middle to its edge, so the middle third is on no side.
_PART: Final = 1 / 3


@dataclass(frozen=True)
class Spot:
    """What is asked of a place in addition to relation and anchor.

    Attributes:
        side: of the anchor; None: any.
        facing: whether the object's front looks where the anchor's does, as a laptop on a desk should.
        room: number of the anchor's room; None: any.
    """

    side: Side | None = None
    facing: bool = False
    room: int | None = None

    def holds(
        self, scene: Surroundings, relation: Relation, anchor: int, centres: Array, extent: Array
    ) -> NDArray[np.bool_]:
        """Whether objects are on the side that is asked for.

        For ``nextto``, the centre must lie beyond that side of the anchor, within its width (or the object's, if more).
        Else it must lie in the outer third of the anchor's surfaces, such as the bed without its pillows.

        Args:
            scene: the home and its arrangement.
            relation: to the anchor.
            anchor: instance.
            centres: (n, 2) of the objects, metres.
            extent: (2,) size of the object along x and y, metres.

        Returns:
            (n,) bool.
        """
        if self.side is None:
            return np.ones(len(centres), np.bool_)
        beside = relation == "nextto"
        box = scene.boxes[anchor] if beside else _around_tops(scene, anchor)
        to_side = np.round(scene.standing[anchor].turn[:2, :2] @ np.array(_AHEAD_LEFT[self.side]), 3)
        if np.hypot(*to_side) < 0.5:  # the anchor lies on its front or back
            return np.zeros(len(centres), np.bool_)
        away = centres - (box[:2] + box[3:5]) / 2
        half = np.abs(np.stack([to_side, to_side[::-1]])) @ (box[3:5] - box[:2]) / 2
        along, across = away @ to_side, np.abs(away @ np.array([-to_side[1], to_side[0]]))
        if beside:
            widest = max(half[1], (np.abs(to_side[::-1]) @ extent) / 2)
            return np.asarray((along >= half[0]) & (across <= widest), np.bool_)
        return np.asarray(along >= _PART * half[0], np.bool_)

    def faces(self, scene: Surroundings, anchor: int, pose: SlotPose) -> bool:
        """Whether an object in a pose faces as asked for.

        Args:
            scene: the home and its arrangement.
            anchor: instance.
            pose: orientation of the object.
        """
        return not self.facing or bool(pose.turn[:, 0] @ scene.standing[anchor].turn[:, 0] > 0.9)


def _around_tops(scene: Surroundings, anchor: int) -> Array:
    """(6,) box around the surfaces of an instance, or its own where it has none."""
    tops = scene.levels.box[scene.levels_of(anchor, SURFACE)]
    return np.concatenate([tops[:, :3].min(axis=0), tops[:, 3:].max(axis=0)]) if len(tops) else scene.boxes[anchor]


#: Nothing is asked for.
ANYWHERE: Final = Spot()
