"""``place``: from (category, relation, anchor) to a settled pose, or the reason why there is none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.objects.model import RELATIONS, Relation
from ucon.sim.arrangement import Arrangement, PlacedObject
from ucon.sim.house import House
from ucon.sim.placement import inside, nextto, ontop, under
from ucon.sim.placement.common import PlacementRequest
from ucon.sim.placement.floor import can_spare, nodes_taken
from ucon.sim.placement.predicates import holds
from ucon.sim.placement.reasons import Reason, RefusedError
from ucon.sim.placement.settle import Miss, Settled, settle
from ucon.sim.placement.slots import Slot
from ucon.sim.placement.spot import ANYWHERE, Spot
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import enclosing, object_box, primitive_boxes, quat_of_matrix, solid

_SAMPLERS: dict[str, Callable[[PlacementRequest], Iterator[Slot]]] = {
    "ontop": ontop.candidates,
    "inside": inside.candidates,
    "under": under.candidates,
    "nextto": nextto.candidates,
}
_MAX_SLOTS = 60
_MAX_FALLS = 6


def place(
    house: House,
    arrangement: Arrangement,
    category: str,
    relation: Relation,
    anchor: int,
    rng: np.random.Generator,
    spot: Spot = ANYWHERE,
) -> PlacedObject:
    """Place one object at an anchor and let it settle.

    The result is the same for the same arguments and state of ``rng``. It is not yet part of the arrangement:
    :func:`with_object` adds it.

    Args:
        house: the compiled home.
        arrangement: what the episode changed so far.
        category: of the object.
        relation: ``ontop``, ``inside``, ``under`` or ``nextto``.
        anchor: instance number, of the house or of an object in ``arrangement``.
        rng: source of all choices.
        spot: further demands on the place: side and facing; its ``room`` is left to the caller's choice of an anchor.

    Raises:
        RefusedError: a :class:`PlacementError` with a ``reason``.
    """
    scene = Surroundings(house, arrangement)
    row = catalogue()[category]
    if relation not in RELATIONS:
        raise RefusedError("implausible", f"'{relation}' is no relation; expected one of {', '.join(RELATIONS)}")
    if not scene.is_present(anchor):
        raise RefusedError("absent_anchor", f"instance {anchor} is not in {house.spec.name}")
    if row.mount == "structure":
        raise RefusedError("implausible", f"{category} is part of a building and cannot be put anywhere")
    return _first(PlacementRequest(scene, category, solid(category), anchor, rng, relation, spot))


def with_object(house: House, arrangement: Arrangement, placed: PlacedObject) -> Arrangement:
    """The arrangement with one more object and the nodes that it blocks."""
    scene = Surroundings(house, arrangement)
    taken = {(int(i), int(j)) for i, j in nodes_taken(scene, object_box(placed))}
    blocked = tuple(sorted(taken | set(arrangement.blocked)))
    return replace(arrangement, objects=(*arrangement.objects, placed), blocked=blocked)


def _first(request: PlacementRequest) -> PlacedObject:
    """The first slot at which the object settles and the relation holds."""
    relation = request.relation
    reason: Reason = "no_free_slot"
    falls: Counter[float] = Counter()
    for slot in islice(_SAMPLERS[relation](request), _MAX_SLOTS):
        upright = round(float(slot.pose.turn[2, 2]), 3)
        if falls[upright] >= _MAX_FALLS:
            continue  # It cannot stand this way, but perhaps lie.
        if not can_spare(request.scene, nodes_taken(request.scene, slot.box)):
            reason = "blocks_path"
            continue
        settled = settle(request.scene, request.shape, slot)
        if settled is Miss.BLOCKED:
            continue
        if isinstance(settled, Settled) and _is_right(request, relation, settled):
            return placed_object(request, relation, settled)
        reason = "unstable"
        falls[upright] += 1
    raise RefusedError(reason, f"no place found for {request.category} {relation} {request.anchor_name}")


def _is_right(request: PlacementRequest, relation: Relation, settled: Settled) -> bool:
    box = enclosing(primitive_boxes(request.shape, settled.position, settled.turn))
    scene, anchor = request.scene, request.anchor
    if relation != "inside":
        # Next to something in the open, it must not end up inside a cupboard.
        own = scene.boxes[anchor]
        expected = scene.holder_at((own[:3] + own[3:]) / 2, but=anchor)[0]
        if scene.holder_at((box[:3] + box[3:]) / 2)[0] != expected:
            return False
    centre, extent = (box[None, :2] + box[None, 3:5]) / 2, box[3:5] - box[:2]
    if not request.spot.holds(scene, relation, anchor, centre, extent)[0]:  # it slid or rolled away
        return False
    return holds(scene, relation, anchor, box, settled.contacts) and can_spare(scene, nodes_taken(scene, box))


def placed_object(request: PlacementRequest, relation: Relation, settled: Settled) -> PlacedObject:
    """The settled object as plain data, with its room and what hides or carries it."""
    scene = request.scene
    box = enclosing(primitive_boxes(request.shape, settled.position, settled.turn))
    centre = (box[:3] + box[3:]) / 2
    holder, compartment = scene.holder_at(centre)
    x, y, z = (float(v) for v in settled.position)
    return PlacedObject(
        category=request.category,
        position=(x, y, z),
        quat_xyzw=quat_of_matrix(settled.turn),
        room=scene.room_at(float(centre[0]), float(centre[1]), scene.room_of(request.anchor)),
        relation=relation,
        anchor=request.anchor,
        holder=holder,
        compartment=compartment,
    )
