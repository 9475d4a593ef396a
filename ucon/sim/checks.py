"""Checks of every home: no overlaps, joints that move freely, compartments that can be seen into."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.scenes.spec import HomeSpec
from ucon.sim.house import STRUCTURE, NavGrid
from ucon.sim.shapes import Array, item_box, item_solid, item_turn
from ucon.sim.world import World

MAX_PENETRATION_M = 0.005
#: Height of the agent's camera, and reach of Open, metres.
EYE_M = 1.25
REACH_M = 1.0
#: Fractions of the travel at which a joint is tested.
SWEEP = (0.5, 1.0)
IN_WALL = frozenset({"door", "window", "gate", "garage_door", "sliding_door", "elevator_door"})
"""Categories that are set into a wall or an opening, and may penetrate it."""


@dataclass(frozen=True)
class HomeProblem:
    """One fault of a home."""

    kind: str
    """``overlap``, ``sweep`` or ``hidden``."""
    instance: int
    """The instance with the fault."""
    other: int
    """The instance it collides with; -1 for none."""
    text: str
    """The fault as text."""


def overlaps(world: World) -> list[HomeProblem]:
    """Pairs that penetrate by more than 5 mm: items with items, and items with structure."""
    spec, problems = world.spec, []
    for instance in range(len(spec.items)):
        for other, distance in world.contacts(instance, 0.0).items():
            pair_seen = other < instance
            if distance < -MAX_PENETRATION_M and not pair_seen and not _exempt(spec, instance, other):
                text = f"{label(spec, instance)} and {label(spec, other)} overlap by {-1000 * distance:.0f} mm"
                problems.append(HomeProblem("overlap", instance, other, text))
    return problems


def sweeps(world: World) -> list[HomeProblem]:
    """Joints that hit something while they open."""
    spec, problems = world.spec, []
    for instance in openables(spec):
        for fraction in SWEEP:
            world.set_open(instance, fraction)
            for other, distance in _moving_contacts(world, instance).items():
                if distance < -MAX_PENETRATION_M and not _exempt(spec, instance, other):
                    text = (
                        f"{label(spec, instance)} opened to {fraction:.0%} hits {label(spec, other)} "
                        f"by {-1000 * distance:.0f} mm"
                    )
                    problems.append(HomeProblem("sweep", instance, other, text))
        world.set_open(instance, 0.0)
    return problems


def hidden(world: World, grid: NavGrid) -> list[HomeProblem]:
    """Openables with compartments, none of which can be seen into from any free node within reach when fully open."""
    problems = []
    for instance in openables(world.spec):
        item = world.spec.items[instance]
        compartments = item_solid(item).model.compartments
        world.set_open(instance, 1.0)
        nodes = near_nodes(grid, item_box(item), REACH_M)
        seen = [_seen(world, instance, k, grid.xy(nodes)) for k in range(len(compartments))]
        if compartments and not any(seen):
            text = f"no free node within {REACH_M:g} m sees into {label(world.spec, instance)} when it is open"
            problems.append(HomeProblem("hidden", instance, -1, text))
        world.set_open(instance, 0.0)
    return problems


def openables(spec: HomeSpec) -> list[int]:
    """Numbers of the items with joints."""
    return [number for number, item in enumerate(spec.items) if item_solid(item).model.openable]


def near_nodes(grid: NavGrid, box: Array, within_m: float) -> NDArray[np.int64]:
    """Free nodes near a box, the nearest first.

    Args:
        grid: the home's grid.
        box: (6,) metres.
        within_m: greatest horizontal distance.

    Returns:
        (n, 2) int64.
    """
    nodes = np.argwhere(grid.free)
    xy = grid.xy(nodes)
    gap = np.maximum(np.maximum(box[:2] - xy, xy - box[3:5]), 0.0)
    distance = np.hypot(gap[:, 0], gap[:, 1])
    order = np.argsort(distance, kind="stable")
    return nodes[order[: int((distance <= within_m).sum())]]


def label(spec: HomeSpec, instance: int) -> str:
    """An instance as text: category, number, room."""
    if instance < len(spec.items):
        item = spec.items[instance]
        return f"{item.category} #{instance} in {spec.rooms[item.room].name}"
    room, kind = divmod(instance - len(spec.items), 3)
    return f"{STRUCTURE[kind]} of {spec.rooms[room].name}"


def _exempt(spec: HomeSpec, instance: int, other: int) -> bool:
    return other >= len(spec.items) and spec.items[instance].category in IN_WALL


def _moving_contacts(world: World, instance: int) -> dict[int, float]:
    body = world.bodies(instance)[0]
    found: dict[int, float] = {}
    for link in range(world.bullet.getNumJoints(body, physicsClientId=world.client)):
        low, high = world.bullet.getAABB(body, link, physicsClientId=world.client)
        for other, distance in world.near(body, link, np.array(low), np.array(high), 0.0).items():
            found[other] = min(distance, found.get(other, np.inf))
    return found


def _seen(world: World, instance: int, compartment: int, xy: Array) -> bool:
    """Whether a ray from the camera at a node reaches a point inside the open compartment."""
    item = world.spec.items[instance]
    model = item_solid(item).model
    space = model.compartments[compartment]
    points = _inner_points(np.array(space.box))
    if space.link >= 0 and model.joints[space.link].kind == "prismatic":
        joint = model.joints[space.link]
        points = points + np.array(joint.axis) * joint.travel
    points = points @ item_turn(item).T + np.array(item.position)
    for x, y in xy:
        start = [(float(x), float(y), EYE_M)] * len(points)
        hits = world.bullet.rayTestBatch(start, points.tolist(), physicsClientId=world.client)
        if any(hit[0] < 0 for hit in hits):
            return True
    return False


def _inner_points(box: Array) -> Array:
    """Six points (6, 3) low inside a box, near its front, where things would stand."""
    x = box[0] + (box[3] - box[0]) * np.array([0.85, 0.6])
    y = box[1] + (box[4] - box[1]) * np.array([0.25, 0.5, 0.75])
    z = box[2] + min(0.05, 0.5 * (box[5] - box[2]))
    return np.array([(a, b, z) for a in x for b in y])
