"""Places worth going to, as a short list: frontiers, things not looked at yet, closed containers.

This is the choice that waypoint policies and language models are given. The searching agents of this repository
value every view instead (:mod:`ucon.perception.viewpoints`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.perception.approach import Approach
from ucon.perception.places import Places, affordance
from ucon.perception.planner import UNREACHED, Planner
from ucon.perception.semantic_map import SIZE, SemanticMap, View
from ucon.perception.view_kernels import OPAQUE_M

Kind = Literal["frontier", "landmark", "container", "view", "wander"]
KINDS: tuple[Kind, ...] = ("frontier", "landmark", "container", "view", "wander")


@dataclass(frozen=True, slots=True)
class Candidate:
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
    found = frontiers(known, planner)
    left = places.left(known.n_tracks).sum(1)
    total = np.zeros((known.n_tracks, 4))
    np.add.at(total, (places.track, places.relation), places.share)
    share = left / np.maximum(total.sum(1), 1e-9)
    approach = Approach()
    for track in range(known.n_tracks):
        name = known.category[track]
        if not name or known.kind[track] or not known.seen(track):
            continue
        has = affordance(name)
        closed = has.openable and not known.opened[track]
        if not closed and not (has.furniture and share[track] > least_unseen):
            continue
        view = approach.goal(known, planner, track)
        if view is not None and planner.cost(view) < UNREACHED:
            kind: Kind = "container" if closed else "landmark"
            unseen = 1.0 if closed else float(share[track])
            found.append(Candidate(kind, view, planner.cost(view), track, name, unseen=unseen))
    return sorted(found, key=lambda c: (c.kind, c.cost, c.track, c.view.i, c.view.j))


def frontiers(known: SemanticMap, planner: Planner, least_cells: int = 3) -> list[Candidate]:
    """Groups of reachable explored nodes next to unexplored space, each with the pose that faces the unknown."""
    i0, i1, j0, j1 = known.extent(1)
    window = (slice(i0, i1), slice(j0, j1))
    unknown = (known.explored[window] == 0) & (known.height[window] < OPAQUE_M)
    beside = np.zeros(unknown.shape, bool)
    beside[1:] |= unknown[:-1]
    beside[:-1] |= unknown[1:]
    beside[:, 1:] |= unknown[:, :-1]
    beside[:, :-1] |= unknown[:, 1:]
    edge = beside & (known.explored[window] > 0) & (planner.steps[window].min(2) < UNREACHED)
    count, label = cv2.connectedComponents(edge.astype(np.uint8), connectivity=8)
    found = []
    for number in range(1, count):
        cells = np.argwhere(label == number) + np.array([i0, j0])
        if len(cells) >= least_cells:
            view = _facing_unknown(cells, known, planner)
            found.append(Candidate("frontier", view, planner.cost(view), cells=len(cells)))
    return sorted(found, key=lambda c: (c.cost, c.view.i, c.view.j))


def _facing_unknown(cells: NDArray[np.int64], known: SemanticMap, planner: Planner) -> View:
    """The node of a group nearest to its middle, looking where most of its unexplored neighbours are."""
    i, j = cells[np.abs(cells - cells.mean(0)).sum(1).argmin()]
    votes = [0, 0, 0, 0]
    for heading, (di, dj) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1))):
        near = np.clip(cells + np.array([di, dj]), 0, SIZE - 1)
        votes[heading] = int(np.count_nonzero(known.explored[near[:, 0], near[:, 1]] == 0))
    best = max(votes)
    headings = [h for h in range(4) if votes[h] == best]
    return View(int(i), int(j), min(headings, key=lambda h: (int(planner.steps[i, j, h]), h)))
