"""What the four samplers share: a request, and turning scored centres into ordered slots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Category
from ucon.sim.placement.kernels import rug_tops
from ucon.sim.placement.slots import Slot, SlotPose, clear, flipped, nearest_node_m, slot_boxes, slots_at
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import Array, Solid

RUG_M = 0.045
"""What lies on the floor and is thinner than this is stood on, not avoided."""
_FLOOR_M = 0.002
SEEN_BEST_M = 1.1
"""Levels above this are looked at from the side: what stands far back on them is hidden by their edge."""


@dataclass(frozen=True, eq=False)
class PlacementRequest:
    """Put ``category`` by ``anchor``."""

    scene: Surroundings
    category: str
    shape: Solid
    anchor: int
    rng: np.random.Generator

    @property
    def row(self) -> Category:
        """Catalogue row of the object."""
        return catalogue()[self.category]

    @property
    def anchor_name(self) -> str:
        """Category of the anchor."""
        return self.scene.categories[self.anchor]

    @property
    def anchor_box(self) -> Array:
        """Box (6,) of the anchor."""
        return self.scene.boxes[self.anchor]


def ordered(
    request: PlacementRequest,
    centres: Array,
    z: float | Array,
    pose: SlotPose,
    penalty: Array | float = 0.0,
    keep: int = 24,
) -> Iterator[Slot]:
    """Slots at the centres (n, 2) that are clear, lowest ``penalty`` plus noise first, at most ``keep``."""
    if not len(centres):
        return
    noise = request.rng.random(len(centres))
    boxes = slot_boxes(centres, z, pose)
    if isinstance(z, float) and abs(z) < _FLOOR_M:
        rugs = rug_tops(request.scene.parts.boxes, boxes, RUG_M)
        z, penalty = z + rugs[:, 0], penalty + 5.0 * rugs[:, 1]  # Half on a rug it would stand askew.
        boxes = slot_boxes(centres, z, pose)
    order = np.argsort(noise + penalty, kind="stable")
    turned = flipped(request.shape, pose, request.rng)
    found = 0
    for start in range(0, len(order), 64):
        rows = order[start : start + 64]
        rows = rows[clear(request.scene, boxes[rows])]
        yield from slots_at(centres, z, turned, rows[: keep - found])
        found += len(rows)
        if found >= keep:
            return


def depth_penalty(request: PlacementRequest, centres: Array, z: float) -> Array | float:
    """Penalty (n,) for standing far from where the agent can be, strong on levels above its chest."""
    weight = 6.0 if z > SEEN_BEST_M else 1.0
    distance = nearest_node_m(request.scene, centres, request.scene.room_of(request.anchor))
    return weight * (distance - distance.min(initial=np.inf)) if len(distance) else 0.0


def alternate(iterators: list[Iterator[Slot]]) -> Iterator[Slot]:
    """One slot of each in turn, until all are spent."""
    waiting = list(iterators)
    while waiting:
        for iterator in list(waiting):
            slot = next(iterator, None)
            if slot is None:
                waiting.remove(iterator)
            else:
                yield slot
