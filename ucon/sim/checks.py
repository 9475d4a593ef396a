"""What must hold in every home before anybody may use it: no overlaps, joints that swing freely, insides that show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ucon.scenes.spec import HomeSpec
from ucon.sim.house import STRUCTURE, NavGrid
from ucon.sim.shapes import Array, item_box, item_solid, item_turn
from ucon.sim.world import World

MAX_PENETRATION_M = 0.005
EYE_M = 1.25
REACH_M = 1.0
SWEEP = (0.5, 1.0)
IN_WALL = frozenset({"door", "window", "gate", "garage_door", "sliding_door", "elevator_door"})
"""Categories that sit in an opening or a wall by nature."""


@dataclass(frozen=True)
class HomeProblem:
    """One thing that is wrong with a home."""

    kind: str
    """``overlap``, ``sweep`` or ``hidden``."""
    instance: int
    other: int
    text: str


def overlaps(world: World) -> list[HomeProblem]:
    """Pairs that penetrate by more than 5 mm, items among themselves and with walls, floors and ceilings."""
    spec, problems = world.spec, []
    for instance in range(len(spec.items)):
        for other, distance in world.contacts(instance, 0.0).items():
            pair_seen = other < instance
            if distance < -MAX_PENETRATION_M and not pair_seen and not _exempt(spec, instance, other):
                text = f"{label(spec, instance)} and {label(spec, other)} overlap by {-1000 * distance:.0f} mm"
                problems.append(HomeProblem("overlap", instance, other, text))
    return problems


def sweeps(world: World) -> list[HomeProblem]:
    """Joints that hit something on their way to fully open."""
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
    """Openables with a compartment that no standing node sees into when everything on them is open."""
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
    """Items with joints."""
    return [number for number, item in enumerate(spec.items) if item_solid(item).model.openable]


def near_nodes(grid: NavGrid, box: Array, within_m: float) -> NDArray[np.int64]:
    """Free nodes (n, 2) within a horizontal distance of a box, nearest first."""
    nodes = np.argwhere(grid.free)
    xy = grid.xy(nodes)
    gap = np.maximum(np.maximum(box[:2] - xy, xy - box[3:5]), 0.0)
    distance = np.hypot(gap[:, 0], gap[:, 1])
    order = np.argsort(distance, kind="stable")
    return nodes[order[: int((distance <= within_m).sum())]]


def label(spec: HomeSpec, instance: int) -> str:
    """Name of an instance for messages: category, number, room."""
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
    """Whether a ray from a node's eye reaches a point inside the open compartment."""
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
    """Points low inside a box, (6, 3): where things would stand, nearer the front."""
    x = box[0] + (box[3] - box[0]) * np.array([0.85, 0.6])
    y = box[1] + (box[4] - box[1]) * np.array([0.25, 0.5, 0.75])
    z = box[2] + min(0.05, 0.5 * (box[5] - box[2]))
    return np.array([(a, b, z) for a in x for b in y])
