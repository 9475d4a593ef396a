"""The common part of the four samplers: the request, and turning scored centres into ordered slots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Category, Relation
from ucon.sim.placement.kernels import rug_tops
from ucon.sim.placement.slots import Slot, SlotPose, clear, flipped, half_turned, nearest_node_m, slot_boxes, slots_at
from ucon.sim.placement.spot import ANYWHERE, Spot
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import Array, Solid

RUG_M = 0.045
"""Things on the floor that are thinner than this, metres, may be stood on."""
_FLOOR_M = 0.002
SEEN_BEST_M = 1.1
"""Above this height, metres, a level's edge hides what stands far back on it."""


@dataclass(frozen=True, eq=False)
class PlacementRequest:
    """A request to place ``category`` at the instance ``anchor``.

    Attributes:
        scene: the home and its arrangement.
        category: of the object.
        shape: its collision primitives.
        anchor: instance.
        rng: random numbers.
        relation: to the anchor.
        spot: further demands on the place: side and facing.
    """

    scene: Surroundings
    category: str
    shape: Solid
    anchor: int
    rng: np.random.Generator
    relation: Relation = "ontop"
    spot: Spot = ANYWHERE

    @property
    def row(self) -> Category:
        """The object's row of the catalogue."""
        return catalogue()[self.category]

    @property
    def anchor_name(self) -> str:
        """Category of the anchor."""
        return self.scene.categories[self.anchor]

    @property
    def anchor_box(self) -> Array:
        """(6,) box of the anchor, metres."""
        return self.scene.boxes[self.anchor]


def ordered(
    request: PlacementRequest,
    centres: Array,
    z: float | Array,
    pose: SlotPose,
    penalty: Array | float = 0.0,
    keep: int = 24,
) -> Iterator[Slot]:
    """Slots at those of some centres that are clear, in order of penalty plus noise.

    Args:
        request: the request.
        centres: (n, 2) footprint centres, metres.
        z: height to stand at, one or (n,).
        pose: orientation of the object.
        penalty: lower is better, one or (n,).
        keep: most slots.
    """
    if not len(centres):
        return
    noise = request.rng.random(len(centres))
    boxes = slot_boxes(centres, z, pose)
    if isinstance(z, float) and abs(z) < _FLOOR_M:
        rugs = rug_tops(request.scene.parts.boxes, boxes, RUG_M)
        z, penalty = z + rugs[:, 0], penalty + 5.0 * rugs[:, 1]  # Half on a rug, it would tilt.
        boxes = slot_boxes(centres, z, pose)
    order = np.argsort(noise + penalty, kind="stable")
    if request.spot != ANYWHERE:
        right = request.spot.holds(request.scene, request.relation, request.anchor, centres, pose.extent[:2])
        order = order[right[order]]
    turned = _turned(request, pose)
    if turned is None:
        return
    found = 0
    for start in range(0, len(order), 64):
        rows = order[start : start + 64]
        rows = rows[clear(request.scene, boxes[rows])]
        yield from slots_at(centres, z, turned, rows[: keep - found])
        found += len(rows)
        if found >= keep:
            return


def _turned(request: PlacementRequest, pose: SlotPose) -> SlotPose | None:
    """The pose or its half turn, at random; if the spot asks for facing, one that faces so, or None."""
    turned = flipped(request.shape, pose, request.rng)
    if not request.spot.facing:
        return turned
    ways = (turned, half_turned(request.shape, turned))
    return next((way for way in ways if request.spot.faces(request.scene, request.anchor, way)), None)


def depth_penalty(request: PlacementRequest, centres: Array, z: float) -> Array | float:
    """Penalty for places far from where the agent can be, strong on levels above its chest.

    Args:
        request: the request.
        centres: (n, 2) footprint centres, metres.
        z: height of the level.

    Returns:
        (n,).
    """
    weight = 6.0 if z > SEEN_BEST_M else 1.0
    distance = nearest_node_m(request.scene, centres, request.scene.room_of(request.anchor))
    return weight * (distance - distance.min(initial=np.inf)) if len(distance) else 0.0


def alternate(iterators: list[Iterator[Slot]]) -> Iterator[Slot]:
    """One slot of each iterator in turn, until all are exhausted."""
    waiting = list(iterators)
    while waiting:
        for iterator in list(waiting):
            slot = next(iterator, None)
            if slot is None:
                waiting.remove(iterator)
            else:
                yield slot
