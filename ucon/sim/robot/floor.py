"""The floor of a home in an episode, for a robot of a given build: compiled arrays, no PyBullet.

Everything counts as closed: an open door or drawer is no obstacle, as on the navigation grid.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Remembered, Shared
from ucon.scenes.spec import GRID_M
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.robot.floor_kernels import BUCKET_M, HORIZON_M, FloorTables, clearance, fill_buckets, free_way
from ucon.sim.robot.footprints import Footprints, home_footprints, object_footprints

_HOMES: Remembered[House, dict[tuple[float, float], Footprints]] = Remembered()


class Ground(Protocol):
    """What a moving robot needs to know of the floor: :class:`Floor`, or PyBullet."""

    def free_way(self, x: float, y: float, dx: float, dy: float) -> float:
        """Metres that the robot gets along (dx, dy) from (x, y) before it touches something."""

    def clearance(self, x: float, y: float) -> float:
        """Metres from a point to the nearest thing that the robot can touch, at most ``HORIZON_M``."""


class Floor(Shared):
    """Answers how far a robot gets.

    Attributes:
        radius_m: of the robot.
        low: (2,) least x and y of the home, world metres.
        high: (2,) greatest x and y.
        tables: the footprints, sorted by place.
    """

    def __init__(self, house: House, arrangement: Arrangement, radius_m: float, bottom_m: float, top_m: float) -> None:
        """Collect what can be touched.

        Args:
            house: the home.
            arrangement: what the episode changed.
            radius_m: of the robot.
            bottom_m: its lowest point above the floor; lower things are stepped over.
            top_m: its highest point; higher things are passed under.
        """
        self.radius_m = radius_m
        self._made_of = (house, arrangement, radius_m, bottom_m, top_m)
        self.low = np.array(house.grid.origin_xy)
        self.high = self.low + GRID_M * np.array(house.grid.shape)
        found = _of_home(house, bottom_m, top_m)
        keep = ~np.isin(found.owner, arrangement.removed) if arrangement.removed else np.ones(len(found.owner), bool)
        chosen = np.flatnonzero(keep)
        points = [found.points[k] for k in chosen]
        rounding = [found.rounding[k] for k in chosen]
        for number, placed in enumerate(arrangement.objects):
            more = object_footprints(placed, house.n_instances + number, bottom_m, top_m)
            points += more.points
            rounding += more.rounding
        self.tables = _tables(house, points, np.array(rounding, float))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the arguments it was built from, not the tables."""
        return Floor, self._made_of

    def free_way(self, x: float, y: float, dx: float, dy: float) -> float:
        """Metres that the robot gets along (dx, dy) from (x, y) before it touches something."""
        return float(free_way(x, y, dx, dy, self.radius_m, self.tables))

    def clearance(self, x: float, y: float) -> float:
        """Metres from a point to the nearest thing that the robot can touch, at most ``HORIZON_M``."""
        return float(clearance(x, y, self.tables))


def _of_home(house: House, bottom_m: float, top_m: float) -> Footprints:
    """Footprints of a home; computed once per process."""
    by_height = _HOMES.setdefault(house, {})
    if (bottom_m, top_m) not in by_height:
        by_height[bottom_m, top_m] = home_footprints(house.spec, bottom_m, top_m)
    return by_height[bottom_m, top_m]


def _tables(house: House, points: list[NDArray[np.float64]], rounding: NDArray[np.float64]) -> FloorTables:
    """Footprints as arrays, sorted into buckets."""
    sizes = np.array([len(corners) for corners in points])
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    corners = np.concatenate(points)
    low = np.minimum.reduceat(corners, first[:-1]) - rounding[:, None]
    high = np.maximum.reduceat(corners, first[:-1]) + rounding[:, None]
    boxes = np.concatenate([low, high], 1)
    reach = np.concatenate([low - HORIZON_M, high + HORIZON_M], 1)
    origin = np.array(house.grid.origin_xy) - BUCKET_M
    shape = tuple(int(n * GRID_M / BUCKET_M) + 3 for n in house.grid.shape)
    counts = np.zeros(shape, np.int32)
    fill_buckets(reach, counts, np.empty(0, np.int32), origin)
    ends = np.cumsum(counts.ravel()).astype(np.int32).reshape(shape)
    begins = ends - counts
    member = np.empty(int(counts.sum()), np.int32)
    fill_buckets(reach, begins.copy(), member, origin)
    return FloorTables(corners, first, rounding, boxes, origin, begins, ends, member)
