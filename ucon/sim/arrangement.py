"""The difference between a compiled home and an episode in it: removed items, added objects, blocked nodes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ucon.core.sharing import Shared
from ucon.objects.model import Relation, Vec3

Quat = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class PlacedObject:
    """One object that the episode adds, at its settled pose.

    Its instance number is ``house.n_instances`` plus its index in the arrangement.

    Attributes:
        category: of the catalogue.
        position: model origin (centre of the footprint, bottom) in the world with all joints closed, metres.
        quat_xyzw: unit quaternion.
        room: number of its room.
        relation: to the anchor; ``imported`` for an anchor that was added.
        anchor: instance it is placed by; for ``imported``, the instance it stands on or hangs at.
        tint: colour variant.
        holder: instance whose joint carries it (drawer) or whose doors hide it (cabinet); -1 for none.
        compartment: compartment of the holder's model that it is in; -1 for none.
    """

    category: str
    position: Vec3
    quat_xyzw: Quat
    room: int
    relation: Relation | Literal["imported"]
    anchor: int
    tint: int = 0
    holder: int = -1
    compartment: int = -1


@dataclass(frozen=True, slots=True)
class Arrangement(Shared):
    """The difference between a home and one episode in it."""

    removed: tuple[int, ...] = ()
    """Instances of the home that are removed: its own instances of the sampled categories."""
    objects: tuple[PlacedObject, ...] = ()
    """Objects that are added."""
    blocked: tuple[tuple[int, int], ...] = field(default=())
    """Nodes of the navigation grid that objects on the floor block."""
