"""Directions to go in: one candidate for each heading in which the path is free (PixelNav, LGX)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View
from ucon.perception.mapping.sightings import Sighting
from ucon.perception.views.candidates import Candidate
from ucon.perception.views.node_kernels import nodes_ahead

#: Which node in a direction to go to: a random one, the farthest, or the one nearest the centre of the floor in view.
Goal = Literal["random", "farthest", "floor"]
_MOST_NODES = 4096


def directions(
    known: SemanticMap,
    planner: Planner,
    sightings: Sequence[Sighting],
    goal: Goal,
    reach_m: tuple[float, float],
    draw: np.random.Generator,
) -> list[Candidate]:
    """One candidate for each sighting in whose direction a node can be reached.

    Args:
        known: the map.
        planner: paths from the current pose; must be up to date.
        sightings: what was seen from the current node, one for each heading.
        goal: which of the nodes in view to go to.
        reach_m: least and greatest distance of nodes, metres.
        draw: random numbers, for ``random``.

    Returns:
        In the order of the sightings.
    """
    found = []
    for sighting in sightings:
        nodes, distance = in_view(known, planner, sighting.view, reach_m)
        if not len(nodes):
            continue
        i, j = nodes[_pick(goal, nodes, distance, sighting, draw)].tolist()
        view = View(i, j, sighting.view.heading)
        free_m = round(float(distance.max()), 2)
        found.append(Candidate("view", view, planner.cost(view), things=sighting.things, free_m=free_m))
    return found


def in_view(
    known: SemanticMap, planner: Planner, view: View, reach_m: tuple[float, float]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Explored, reachable nodes that are in view from a pose.

    Args:
        known: the map.
        planner: paths from the current pose; must be up to date.
        view: the pose; its pitch is not used.
        reach_m: least and greatest distance of nodes, metres.

    Returns:
        Nodes (n, 2) int32 and their distances (n,) float64 in metres.
    """
    nodes, distance = np.empty((_MOST_NODES, 2), np.int32), np.empty(_MOST_NODES)
    cells = (planner.steps, known.explored, known.height, known.walls, HALF)
    pose = (view.i, view.j, view.heading)
    n = nodes_ahead(pose, reach_m, known.body.camera_m, cells, UNREACHED, nodes, distance)
    return nodes[:n], distance[:n]


def _pick(
    goal: Goal,
    nodes: NDArray[np.int32],
    distance: NDArray[np.float64],
    sighting: Sighting,
    draw: np.random.Generator,
) -> int:
    """Row of the node to go to."""
    if goal == "random":
        return int(draw.integers(len(nodes)))
    if goal == "floor" and sighting.floor_xy is not None:
        gap = (nodes - HALF) * CELL_M - np.array(sighting.floor_xy)
        return int((gap**2).sum(1).argmin())
    return int(distance.argmax())
