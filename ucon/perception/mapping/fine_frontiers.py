"""The frontiers of L3MVN: at most four stretches of the edge of explored space on the 5 cm map, the most useful first.

As in the original: the explored cells are closed (5 x 5) and the outline of the largest region is drawn one cell thick.
Cells within two cells of the map's border and obstacles grown by one cell are taken out. What remains is split into
connected groups (8 neighbours). A group is a frontier if it has more than four cells and lies between 0.5 m and 5 m
away. Its utility is its number of cells, plus 8 if it is nearer than 3 m. Only the outer outline counts: unexplored
space inside explored space is no frontier.

Unlike the original:

- The original's loop over groups starts at 1, which skips the first group by mistake; here all count.
- A group's centre may lie off the group (in a bend): the cell of the group that is nearest to it is used.
- A frontier is dropped if no explored, reachable node of the 0.25 m map is near; then the best four are kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import heading_to
from ucon.perception.mapping.fine_kernels import EXPLORED, FINE_M, OBSTACLE, PER_CELL, walk
from ucon.perception.mapping.fine_map import FINE_SIZE, Box, Cell, FineMap, cell_of, middle_of
from ucon.perception.mapping.map_kernels import RADIUS_M
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SIZE, SemanticMap, View

#: Most frontiers, and least cells of one.
MOST = 4
LEAST_CELLS = 5
#: Path length to a frontier, metres.
NEAREST_M, FARTHEST_M = 0.5, 5.0
#: Added to the utility of frontiers nearer than BONUS_M metres.
BONUS, BONUS_M = 8.0, 3.0
#: Largest distance in metres between a frontier and the node to stand on.
SNAP_M = 0.5
#: Side in metres of the square around a frontier in which L3MVN looks for things: a sixth of its window of 24 m (a
#: quarter, 6 m, with the head that it trained).
SQUARE_M = 4.0
_BORDER = 2
#: Radius of the robot in cells of 5 cm.
_ROBOT = int(RADIUS_M / FINE_M)
#: A node counts as on the same side of a wall if the path to it is no longer than this, in metres.
_ASTRAY_M = 1.0
_NEAR_CELLS = round(1.0 / FINE_M)


@dataclass(frozen=True, slots=True)
class FineFrontier:
    """A stretch of the edge of explored space on the 5 cm map."""

    xy: tuple[float, float]
    """Centre of its central cell, metres in the start frame."""
    cells: int
    """Size in cells of 5 cm."""
    distance_m: float
    """Length of the path there around the obstacles seen; unexplored space counts as free, as in the original."""
    utility: float
    """Its cells, plus 8 if it is nearer than 3 m."""
    view: View
    """The pose to go to: an explored, reachable node within 0.5 m, facing the unexplored side."""
    cost: int
    """Actions to reach ``view``."""


def fine_frontiers(fine: FineMap, known: SemanticMap, planner: Planner) -> list[FineFrontier]:
    """Find the frontiers of the 5 cm map.

    Args:
        fine: the 5 cm map.
        known: the 0.25 m map.
        planner: paths on it. All three must have been updated with the same frames.

    Returns:
        At most four, by falling utility.
    """
    box = fine.extent(margin=8)
    explored, edge = outline(fine, box)
    count, label, stats, middle = cv2.connectedComponentsWithStats(edge, connectivity=8)
    ways = _Ways(fine, cell_of(fine.view.xy), FARTHEST_M, _ROBOT)
    found = []
    for number in range(1, count):
        size = int(stats[number, cv2.CC_STAT_AREA])
        if size < LEAST_CELLS:
            continue
        b, a, width, height = (int(v) for v in stats[number, :4])
        cells = np.argwhere(label[a : a + height, b : b + width] == number) + np.array([a, b])
        cell = cells[np.square(cells - middle[number, ::-1]).sum(1).argmin()]
        distance_m = ways.metres((int(cell[0]) + box[0], int(cell[1]) + box[2]))
        if NEAREST_M < distance_m < FARTHEST_M:
            utility = size + (BONUS if distance_m < BONUS_M else 0.0)
            found.append((-utility, distance_m, int(cell[0]), int(cell[1]), cells))
    found.sort(key=lambda entry: entry[:4])
    out: list[FineFrontier] = []
    for loss, distance_m, a, b, cells in found:
        here = (a + box[0], b + box[2])
        if len(out) == MOST:
            break
        view = _pose(here, _votes(explored, cells, (a, b)), fine, known, planner)
        if view is not None:
            out.append(FineFrontier(middle_of(*here), len(cells), distance_m, -loss, view, planner.cost(view)))
    return out


def outline(fine: FineMap, box: Box) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Explored space with small gaps closed, and the frontier cells at its edge.

    Args:
        fine: the 5 cm map.
        box: cells (a0, a1, b0, b1), ends excluded.

    Returns:
        Two arrays (a1 - a0, b1 - b0) uint8 of 0 and 1.
    """
    explored = cv2.morphologyEx(fine.layer(EXPLORED, box), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    edge = np.zeros(explored.shape, np.uint8)
    regions, _ = cv2.findContours(explored, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if regions:
        cv2.drawContours(edge, [max(regions, key=cv2.contourArea)], 0, 1, 1)
    edge[cv2.dilate(fine.layer(OBSTACLE, box), np.ones((3, 3), np.uint8)) > 0] = 0
    for lines, start in ((edge, box[0]), (edge.T, box[2])):  # the map's borders in x, then in y
        lines[: max(_BORDER - start, 0)] = 0
        lines[FINE_SIZE - _BORDER - start :] = 0
    return np.asarray(explored, np.uint8), edge


def labels_near(known: SemanticMap, xy: tuple[float, float], side_m: float = SQUARE_M) -> list[str]:
    """Categories of the things seen in a square around a point, each once, by falling size.

    A thing counts if the box of what was seen of it overlaps the square, as any of its cells would in L3MVN. Structure
    does not count. Equal ones are in alphabetical order.

    Args:
        known: the 0.25 m map.
        xy: centre of the square, metres in the start frame.
        side_m: side of the square, metres.
    """
    half = 0.5 * side_m
    box = known.box[: known.n_tracks]
    over = (box[:, 0] <= xy[0] + half) & (box[:, 3] >= xy[0] - half)
    over &= (box[:, 1] <= xy[1] + half) & (box[:, 4] >= xy[1] - half)
    over &= (box[:, 3] >= box[:, 0]) & (known.kind[: known.n_tracks] == 0)
    area: dict[str, float] = {}
    for track in np.flatnonzero(over).tolist():
        x0, y0, _, x1, y1, _ = box[track]
        name = known.category[track]
        if name:
            area[name] = max(area.get(name, 0.0), float((x1 - x0) * (y1 - y0)))
    return sorted(area, key=lambda name: (-area[name], name))


class _Ways:
    """Lengths of the shortest paths from one cell around obstacles grown by one cell (fast marching), up to a limit."""

    def __init__(self, fine: FineMap, start: Cell, limit_m: float, free: int = 0) -> None:
        """Compute the lengths.

        Args:
            fine: the 5 cm map.
            start: cell (a, b) to start from.
            limit_m: longer paths are infinite; metres.
            free: this many cells to each side of the start count as free, since a robot may stand at an open door.
        """
        span = round(limit_m / FINE_M) + 3
        n = 2 * span + 1
        self._corner = start[0] - span, start[1] - span
        blocked = cv2.dilate(_cut(fine, self._corner, n), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3)))
        blocked[span - free : span + free + 1, span - free : span + free + 1] = 0
        self._way = np.empty((n, n), np.float32)
        queue, waiting = np.empty(n * n, np.int32), np.zeros((n, n), bool)
        walk(np.asarray(blocked, np.uint8), span, span, limit_m / FINE_M, self._way, queue, waiting)

    def metres(self, cell: Cell) -> float:
        """Length of the path to a cell in metres; inf where it exceeds the limit."""
        i, j = cell[0] - self._corner[0], cell[1] - self._corner[1]
        if not (0 <= i < len(self._way) and 0 <= j < len(self._way)):
            return float("inf")
        return float(self._way[i, j]) * FINE_M


def _cut(fine: FineMap, corner: Cell, n: int) -> NDArray[np.uint8]:
    """Obstacles in n x n cells from a corner, which may lie outside the map; (n, n) uint8."""
    out = np.zeros((n, n), np.uint8)
    a0, b0 = max(corner[0], 0), max(corner[1], 0)
    a1, b1 = min(corner[0] + n, FINE_SIZE), min(corner[1] + n, FINE_SIZE)
    out[a0 - corner[0] : a1 - corner[0], b0 - corner[1] : b1 - corner[1]] = fine.layer(OBSTACLE, (a0, a1, b0, b1))
    return out


def _votes(explored: NDArray[np.uint8], cells: NDArray[np.int64], middle: Cell) -> NDArray[np.int64]:
    """For each heading (4,): how many cells of a frontier have unexplored space three cells off in that direction.

    Only cells within 1 m of the frontier's central cell count.
    """
    near = cells[np.abs(cells - np.array(middle)).max(1) <= _NEAR_CELLS]
    steps = np.array([(3, 0), (0, 3), (-3, 0), (0, -3)])
    beside = near[None] + steps[:, None]
    counts: NDArray[np.int64] = (explored[beside[..., 0], beside[..., 1]] == 0).sum(1)
    return counts


def _pose(here: Cell, votes: NDArray[np.int64], fine: FineMap, known: SemanticMap, planner: Planner) -> View | None:
    """The nearest node to stand on for a frontier, facing the heading with most votes (of equal ones the cheapest)."""
    x, y = middle_of(*here)
    ci, cj, span = here[0] // PER_CELL, here[1] // PER_CELL, int(SNAP_M / CELL_M) + 1
    i0, i1, j0, j1 = max(ci - span, 0), min(ci + span + 1, SIZE), max(cj - span, 0), min(cj + span + 1, SIZE)
    steps = planner.steps[i0:i1, j0:j1]
    nodes = np.argwhere((steps.min(2) < UNREACHED) & (known.explored[i0:i1, j0:j1] > 0)) + np.array([i0, j0])
    gaps = np.hypot((nodes[:, 0] - HALF) * CELL_M - x, (nodes[:, 1] - HALF) * CELL_M - y)
    ways = _Ways(fine, here, _ASTRAY_M)
    for k in np.argsort(gaps, kind="stable").tolist():
        i, j = (int(v) for v in nodes[k])
        if gaps[k] > SNAP_M:
            break
        if ways.metres((PER_CELL * i + PER_CELL // 2, PER_CELL * j + PER_CELL // 2)) <= _ASTRAY_M:
            headings = _towards(votes, known.body.headings)
            return View(i, j, min(headings, key=lambda h: (int(planner.steps[i, j, h]), h)))
    return None


def _towards(votes: NDArray[np.int64], n: int) -> list[int]:
    """The headings, out of n, in the direction of most votes (4,)."""
    if n == 4:
        return [h for h in range(4) if votes[h] == votes.max()]
    return [heading_to(float(votes[0] - votes[2]), float(votes[1] - votes[3]), n)]
