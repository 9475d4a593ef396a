"""Candidates to go to, as a short list: frontiers, furniture not looked at yet, closed containers.

Waypoint policies and language models choose from this list. The searching agents of this repository value every view
instead (:mod:`ucon.perception.views.viewpoints`).
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
from ucon.perception.places.affordances import affordance
from ucon.perception.places.target_places import Places
from ucon.perception.views.approach import Approach

Kind = Literal["frontier", "landmark", "container", "view", "wander"]
CANDIDATE_KINDS: tuple[Kind, ...] = ("frontier", "landmark", "container", "view", "wander")


@dataclass(frozen=True, slots=True)
class Candidate(Shared):
    """Something to go to.

    Attributes:
        kind: one of :data:`CANDIDATE_KINDS`.
        view: the pose to go to.
        cost: actions to get there.
        track: of a landmark or container, else -1.
        category: of a landmark or container, else "".
    """

    kind: Kind
    view: View
    cost: int
    track: int = -1
    category: str = ""
    cells: int = 0
    """Size of a frontier, in cells of its map (0.25 m or 5 cm)."""
    unseen: float = 0.0
    """Of a landmark or container: share of its places that no frame has shown yet."""
    things: tuple[tuple[str, int], ...] = ()
    """Categories seen there and the number of each."""
    free_m: float = 0.0
    """Of a view: free distance in that direction, metres."""
    utility: float = 0.0
    """Of a frontier on the 5 cm map: the utility of L3MVN."""


def candidates(known: SemanticMap, planner: Planner, places: Places, *, least_unseen: float = 0.3) -> list[Candidate]:
    """All candidates on the map: frontiers, landmarks and closed containers.

    A landmark is a piece of furniture with more than ``least_unseen`` of its places not shown yet.

    Args:
        known: the map.
        planner: paths from the current pose; must be up to date.
        places: sample points of the map.
        least_unseen: see above, a share.

    Returns:
        By kind, the cheapest first within each kind.
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
    """Groups of reachable explored nodes next to unexplored space, each with a pose that faces it.

    Args:
        known: the map.
        planner: paths from the current pose; must be up to date.
        least_cells: smaller groups are left out.

    Returns:
        The cheapest first.
    """
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
