"""What an episode changes in a compiled home: instances taken away, objects added, nodes they block."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ucon.core.sharing import Shared
from ucon.objects.model import Relation, Vec3

Quat = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class PlacedObject:
    """One object that the episode adds, at its settled pose.

    Its instance number is ``house.n_instances`` plus its index in the arrangement. ``position`` is the model
    origin (centre of the footprint, bottom) in the world with all joints closed.
    """

    category: str
    position: Vec3
    quat_xyzw: Quat
    room: int
    relation: Relation | Literal["imported"]
    anchor: int
    """Instance that it is placed by; its support where it was imported."""
    tint: int = 0
    holder: int = -1
    """Instance whose joint carries it (content of a drawer) or hides it (content of a cabinet); -1: none."""
    compartment: int = -1
    """Compartment of the holder's model that it is in; -1: none."""


@dataclass(frozen=True, slots=True)
class Arrangement(Shared):
    """The difference between a home and one episode in it."""

    removed: tuple[int, ...] = ()
    """Base items taken away (the scene's own instances of the sampled categories)."""
    objects: tuple[PlacedObject, ...] = ()
    blocked: tuple[tuple[int, int], ...] = field(default=())
    """Nodes that objects on the floor take from the navigation grid."""
