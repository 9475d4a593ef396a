"""The navigation grid of a home, from PyBullet overlap tests with an upright cylinder in place of the agent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import SceneError
from ucon.scenes.spec import GRID_M, HomeSpec
from ucon.sim.house import NavGrid
from ucon.sim.paths import components
from ucon.sim.rooms import room_grid
from ucon.sim.world import World

AGENT_RADIUS_M = 0.18
AGENT_BOTTOM_M = 0.05
AGENT_TOP_M = 1.80
MAIN_COMPONENT_SHARE = 0.99
"""The largest component must hold this share of the free nodes; the rest are blocked."""


def free_cells(world: World, origin: tuple[float, float], rooms: NDArray[np.int16]) -> NDArray[np.bool_]:
    """Cells of rooms where the agent's cylinder touches nothing.

    Args:
        world: the home in PyBullet, everything closed.
        origin: corner of cell (0, 0), world metres.
        rooms: (nx, ny) room of each cell, -1 outside.

    Returns:
        (nx, ny) bool.
    """
    p, client = world.bullet, world.client
    height = AGENT_TOP_M - AGENT_BOTTOM_M
    shape = p.createCollisionShape(p.GEOM_CYLINDER, radius=AGENT_RADIUS_M, height=height, physicsClientId=client)
    agent = p.createMultiBody(baseMass=0.0, baseCollisionShapeIndex=shape, physicsClientId=client)
    free = rooms >= 0
    half = np.array([AGENT_RADIUS_M, AGENT_RADIUS_M, height / 2])
    for i, j in np.argwhere(free):
        x, y = origin[0] + (i + 0.5) * GRID_M, origin[1] + (j + 0.5) * GRID_M
        centre = np.array([x, y, AGENT_BOTTOM_M + height / 2])
        hits = p.getOverlappingObjects(tuple(centre - half), tuple(centre + half), physicsClientId=client) or ()
        if not hits:
            continue
        p.resetBasePositionAndOrientation(agent, tuple(centre), (0, 0, 0, 1), physicsClientId=client)
        free[i, j] = not any(
            other != agent
            and p.getClosestPoints(agent, other, 0.0, linkIndexA=-1, linkIndexB=link, physicsClientId=client)
            for other, link in sorted(set(hits))
        )
    p.removeBody(agent, physicsClientId=client)
    return free


def main_component(free: NDArray[np.bool_], name: str, enclosed: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
    """The largest connected component of the free nodes.

    Args:
        free: (nx, ny) bool.
        name: of the home, for errors.
        enclosed: (nx, ny) bool, nodes inside a shower stall or under a slide; they need not be connected.

    Returns:
        (nx, ny) bool.

    Raises:
        SceneError: there is no free node, or the largest component holds less than 99 % of them.
    """
    labels = components(free)
    if labels.max(initial=-1) < 0:
        raise SceneError(f"{name}: no free node; the rooms are too full or too small for the agent")
    sizes = np.bincount(labels[labels >= 0])
    main = labels == int(sizes.argmax())
    floor = free if enclosed is None else main | (free & ~enclosed)
    share = main.sum() / floor.sum()
    if share < MAIN_COMPONENT_SHARE:
        raise SceneError(
            f"{name}: the largest part of the free floor holds {share:.1%} of {floor.sum()} free nodes, expected at "
            f"least {MAIN_COMPONENT_SHARE:.0%}; some furniture or wall cuts the home in pieces {sorted(sizes.tolist())}"
        )
    return main


def enclosed_cells(spec: HomeSpec, origin: tuple[float, float], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Nodes within 0.18 m of an item's box, such as the inside of hollow things: not floor that must be reachable.

    Returns:
        (nx, ny) bool.
    """
    x = origin[0] + (np.arange(shape[0]) + 0.5) * GRID_M
    y = origin[1] + (np.arange(shape[1]) + 0.5) * GRID_M
    found = np.zeros(shape, bool)
    for item in spec.items:
        depth, width, height = item.size
        half = (depth / 2, width / 2) if item.quarter_turns % 2 == 0 else (width / 2, depth / 2)
        low = item.position[2]
        if item.category == "door" or low >= AGENT_TOP_M or low + height <= AGENT_BOTTOM_M:
            continue
        dx = np.maximum(np.abs(x - item.position[0]) - half[0], 0.0)
        dy = np.maximum(np.abs(y - item.position[1]) - half[1], 0.0)
        near = np.ix_(np.flatnonzero(dx < AGENT_RADIUS_M), np.flatnonzero(dy < AGENT_RADIUS_M))
        found[near] |= np.hypot(dx[near[0]], dy[near[1]]) < AGENT_RADIUS_M
    return found


def nav_grid(world: World) -> NavGrid:
    """Compute the grid of a world with everything closed.

    Raises:
        SceneError: the free floor is not in one piece.
    """
    origin, rooms = room_grid(world.spec)
    free = free_cells(world, origin, rooms)
    enclosed = enclosed_cells(world.spec, origin, (rooms.shape[0], rooms.shape[1]))
    return NavGrid(origin, main_component(free, world.spec.name, enclosed), rooms)
