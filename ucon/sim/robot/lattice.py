"""Where a robot without errors can get by whole moves and turns of 60 degrees: a triangular lattice from its start.

Place (a, b) is at ``start + move_m (a e0 + b e1)``, where e0 points along heading 0 and e1 60 degrees to its left; a
move is 0.25 m.
"""

from __future__ import annotations

import heapq
import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import LATTICE_STEPS
from ucon.core.jit import F64, I32, jit
from ucon.core.sharing import Shared
from ucon.sim.robot.floor import Floor
from ucon.sim.robot.floor_kernels import FloorTables, free_way

HEADINGS: Final = 6
#: Cost of a move, where a turn costs 1. Moves count first, since no path has this many turns.
MOVE_COST: Final = 4096
NEVER: Final = np.int32(2**30)
#: Moves are planned with this much extra clearance, metres, so that rounding never makes one of them touch.
_ROOM_M: Final = 1e-6


class Lattice(Shared):
    """The fewest moves, and among these the fewest turns, to every place and heading.

    Attributes:
        start: x, y in world metres.
        yaw_deg: of heading 0.
        half: index of the start along both axes.
        cost: (n, n, 6) int32: ``MOVE_COST`` per move and 1 per turn; ``NEVER`` where no path leads.
    """

    def __init__(
        self, floor: Floor, start: tuple[float, float], yaw_deg: float, move_m: float, heading: int = 0
    ) -> None:
        """Find the paths from a start.

        Args:
            floor: what the robot can touch.
            start: x, y in world metres.
            yaw_deg: of heading 0.
            move_m: length of a move.
            heading: at which paths begin.
        """
        self.start, self.yaw_deg, self._move_m, self._floor = start, yaw_deg, move_m, floor
        angle = np.radians(yaw_deg + 60.0 * np.arange(HEADINGS))
        self._steps = move_m * np.stack([np.cos(angle), np.sin(angle)], 1)
        reach = float(np.hypot(*(floor.high - floor.low)))
        self.half = math.ceil(reach / move_m / math.sqrt(0.75)) + 1
        self.cost = self.costs_from((self.half, self.half), heading)

    def costs_from(self, place: tuple[int, int], heading: int) -> NDArray[np.int32]:
        """Costs (n, n, 6) of the paths from a place (indices of ``cost``) and heading."""
        return _costs(
            np.array(self.start),
            self._steps,
            self.half,
            place,
            heading,
            self._floor.radius_m + _ROOM_M,
            self._floor.tables,
        )

    def xy(self, places: NDArray[np.integer]) -> NDArray[np.float64]:
        """(m, 2) world metres of places (m, 2), given by their indices in ``cost``."""
        return np.array(self.start) + (places - self.half) @ self._steps[:2]

    def path(self, cost: NDArray[np.int32], place: tuple[int, int], heading: int) -> list[int]:
        """A cheapest path to a place and heading.

        Args:
            cost: as :meth:`costs_from` returns it.
            place: indices of the place.
            heading: at the place.

        Returns:
            0 for a move, 1 for a turn to the left, -1 for one to the right, in order.
        """
        found: list[int] = []
        a, b, k = place[0], place[1], heading
        while cost[a, b, k] > 0:
            da, db = LATTICE_STEPS[k].tolist()
            if cost[a - da, b - db, k] + MOVE_COST == cost[a, b, k] and self._passes(a - da, b - db, k):
                a, b = a - da, b - db
                found.append(0)
                continue
            turn = next(t for t in (1, -1) if cost[a, b, (k - t) % HEADINGS] + 1 == cost[a, b, k])
            k = (k - turn) % HEADINGS
            found.append(turn)
        return found[::-1]

    def _passes(self, a: int, b: int, heading: int) -> bool:
        """Whether a move from a place is free along its whole length."""
        step = self._steps[heading]
        x, y = self.xy(np.array([a, b])).tolist()
        radius_m = self._floor.radius_m + _ROOM_M
        return bool(free_way(x, y, step[0], step[1], radius_m, self._floor.tables) >= math.hypot(step[0], step[1]))


@jit
def _costs(
    start: F64, steps: F64, half: int, place: tuple[int, int], heading: int, radius: float, floor: FloorTables
) -> I32:
    """Dijkstra's algorithm over places and headings; see :class:`Lattice`."""
    n = 2 * half + 1
    cost = np.full((n, n, HEADINGS), NEVER, np.int32)
    cost[place[0], place[1], heading] = 0
    queue = [(np.int32(0), place[0], place[1], heading)]
    while len(queue):
        d, a, b, k = heapq.heappop(queue)
        if d > cost[a, b, k]:
            continue
        for turn in (1, HEADINGS - 1):
            other = (k + turn) % HEADINGS
            if d + 1 < cost[a, b, other]:
                cost[a, b, other] = d + 1
                heapq.heappush(queue, (np.int32(d + 1), a, b, other))
        i, j = a + LATTICE_STEPS[k, 0], b + LATTICE_STEPS[k, 1]
        if 0 <= i < n and 0 <= j < n and d + MOVE_COST < cost[i, j, k]:
            x = start[0] + (a - half) * steps[0, 0] + (b - half) * steps[1, 0]
            y = start[1] + (a - half) * steps[0, 1] + (b - half) * steps[1, 1]
            length = math.hypot(steps[k, 0], steps[k, 1])
            if free_way(x, y, steps[k, 0], steps[k, 1], radius, floor) >= length:
                cost[i, j, k] = d + MOVE_COST
                heapq.heappush(queue, (np.int32(d + MOVE_COST), i, j, k))
    return cost
