"""Places worth going to, as a short list: frontiers, things not looked at yet, closed containers.

This is the choice that waypoint policies and language models are given. The searching agents of this repository
value every view instead (:mod:`ucon.perception.views.viewpoints`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from ucon.core.sharing import Shared
from ucon.perception.mapping.frontier_kernels import edges, groups
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import SemanticMap, View
from ucon.perception.places.target_places import Places, affordance
from ucon.perception.views.approach import Approach

Kind = Literal["frontier", "landmark", "container", "view", "wander"]
CANDIDATE_KINDS: tuple[Kind, ...] = ("frontier", "landmark", "container", "view", "wander")


@dataclass(frozen=True, slots=True)
class Candidate(Shared):
    """Something to go to; ``view`` is the pose to go to and ``cost`` the actions it takes."""

    kind: Kind
    view: View
    cost: int
    track: int = -1
    category: str = ""
    cells: int = 0
    """Size of a frontier in cells of 0.25 m."""
    unseen: float = 0.0
    """Share of a thing's places that no frame has shown yet."""
    things: tuple[tuple[str, int], ...] = ()
    """Categories seen there and how many of each."""
    free_m: float = 0.0
    """How far one can go in a direction."""
    utility: float = 0.0
    """Of a frontier on the 5 cm map, as L3MVN rates it."""


def candidates(known: SemanticMap, planner: Planner, places: Places, *, least_unseen: float = 0.3) -> list[Candidate]:
    """All candidates, cheapest first within each kind; the planner must be up to date.

    A landmark is furniture of whose places more than ``least_unseen`` was not shown yet.
    """
    found = frontiers(known, planner) + _things(known, planner, places, least_unseen)
    return sorted(found, key=lambda c: (c.kind, c.cost, c.track, c.view.i, c.view.j))


def _things(known: SemanticMap, planner: Planner, places: Places, least_unseen: float) -> list[Candidate]:
    """Landmarks and closed containers that can be reached, by track."""
    n = known.n_tracks
    has = [affordance(name) for name in known.category]
    closed = np.fromiter((a.openable for a in has), bool, n) & ~known.opened[:n]
    share = places.unseen_share(n)
    offered = closed | np.fromiter((a.furniture for a in has), bool, n) & (share > least_unseen)
    offered &= (known.kind[:n] == 0) & (known.box[:n, 3] >= known.box[:n, 0])
    tracks = np.flatnonzero(offered)
    poses, costs = Approach().goals(known, planner, tracks)
    reached = costs < UNREACHED
    found = []
    for track, pose in zip(tracks[reached].tolist(), poses[reached].tolist(), strict=True):
        kind: Kind = "container" if closed[track] else "landmark"
        unseen = 1.0 if closed[track] else float(share[track])
        view = View(*pose)
        found.append(Candidate(kind, view, planner.cost(view), track, known.category[track], unseen=unseen))
    return found


def frontiers(known: SemanticMap, planner: Planner, least_cells: int = 3) -> list[Candidate]:
    """Groups of reachable explored nodes next to unexplored space, each with the pose that faces the unknown."""
    i0, i1, j0, j1 = window = known.extent(1)
    edge = np.zeros((i1 - i0, j1 - j0), np.uint8)
    edges(window, known.explored, known.height, planner.steps, UNREACHED, edge)
    count, label = cv2.connectedComponents(edge, connectivity=8)
    found = np.zeros((count - 1, 4), np.int32)
    groups(np.asarray(label, np.int32), (i0, j0), known.explored, planner.steps, found)
    out = []
    for i, j, heading, cells in found.tolist():
        if cells >= least_cells:
            view = View(i, j, heading)
            out.append(Candidate("frontier", view, planner.cost(view), cells=cells))
    return sorted(out, key=lambda c: (c.cost, c.view.i, c.view.j))
