"""Nodes that an object on the floor blocks, and whether the home can do without them."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ucon.sim.checks import REACH_M, near_nodes, openables
from ucon.sim.house import House
from ucon.sim.navgrid import AGENT_BOTTOM_M, AGENT_RADIUS_M, AGENT_TOP_M
from ucon.sim.paths import components
from ucon.sim.placement.surroundings import Surroundings
from ucon.sim.shapes import Array, item_turn

#: Free nodes that every room must keep.
LEAST_NODES_A_ROOM = 3

_fronts: WeakKeyDictionary[House, dict[int, NDArray[np.int64]]] = WeakKeyDictionary()


def nodes_taken(scene: Surroundings, box: Array) -> NDArray[np.int64]:
    """Free nodes where the agent's cylinder would touch a box.

    Args:
        scene: the home and its arrangement.
        box: (6,) metres.

    Returns:
        (n, 2) int64.
    """
    none = np.zeros((0, 2), np.int64)
    if box[5] <= AGENT_BOTTOM_M or box[2] >= AGENT_TOP_M:
        return none
    grid = scene.house.grid
    i0, j0 = grid.cell((box[0] - AGENT_RADIUS_M, box[1] - AGENT_RADIUS_M))
    i1, j1 = grid.cell((box[3] + AGENT_RADIUS_M, box[4] + AGENT_RADIUS_M))
    i0, j0 = max(i0, 0), max(j0, 0)
    nodes = np.argwhere(scene.free[i0 : i1 + 1, j0 : j1 + 1]) + np.array([i0, j0])
    if not len(nodes):
        return none
    xy = grid.xy(nodes)
    gap = np.maximum(np.maximum(box[:2] - xy, xy - box[3:5]), 0.0)
    return nodes[np.hypot(gap[:, 0], gap[:, 1]) < AGENT_RADIUS_M]


def can_spare(scene: Surroundings, nodes: NDArray[np.int64]) -> bool:
    """Whether some nodes may be blocked.

    The floor must stay connected, with free nodes in every room and in front of every openable.
    """
    if not len(nodes):
        return True
    free = scene.free.copy()
    free[nodes[:, 0], nodes[:, 1]] = False
    if components(free).max() != 0:
        return False
    grid = scene.house.grid
    for room in np.unique(grid.room[nodes[:, 0], nodes[:, 1]]):
        left = int((free & (grid.room == room)).sum())
        if left < min(LEAST_NODES_A_ROOM, int((grid.free & (grid.room == room)).sum())):
            return False
    fronts = [front for instance, front in _front_nodes(scene.house).items() if scene.is_present(instance)]
    own = [near_nodes(grid, scene.boxes[i], REACH_M) for i in _own_openables(scene)]
    return all(free[front[:, 0], front[:, 1]].any() for front in fronts + own if len(front))


def _own_openables(scene: Surroundings) -> list[int]:
    n = scene.house.n_instances
    return [i for i in range(n, len(scene.standing)) if scene.standing[i].shape.model.openable]


def _front_nodes(house: House) -> dict[int, NDArray[np.int64]]:
    """Free nodes in front of every openable item, within reach."""
    if house not in _fronts:
        result = {}
        for instance in openables(house.spec):
            nodes = near_nodes(house.grid, house.boxes[instance], REACH_M)
            front = item_turn(house.spec.items[instance])[:2, 0]
            ahead = (house.grid.xy(nodes) - house.spec.items[instance].position[:2]) @ front > 0
            result[instance] = nodes[ahead] if ahead.any() else nodes
        _fronts[house] = result
    return _fronts[house]
