"""A compiled home: everything that an episode needs to run without PyBullet.

Instances are numbered: first the items of the spec in order, then for each room r its floor, walls and ceiling
(``n_items + 3 r + 0 / 1 / 2``), then the objects that an episode adds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.scenes.spec import GRID_M, HomeSpec

STRUCTURE = ("floors", "walls", "ceilings")


@dataclass(frozen=True, eq=False)
class NavGrid:
    """The navigation grid: nodes at the centres of 0.25 m cells, 4-connected.

    Node (i, j) is at ``origin + (i + 0.5, j + 0.5) * 0.25``. A move between two free neighbours is always legal: a wall
    between them would block one of them, since walls are on cell borders and need 0.18 m of clearance.

    Attributes:
        origin_xy: corner of cell (0, 0), world metres.
        free: (nx, ny) bool, nodes where the agent can stand.
        room: (nx, ny) int16, number of the room, -1 outside.
    """

    origin_xy: tuple[float, float]
    free: NDArray[np.bool_]
    room: NDArray[np.int16]

    @property
    def shape(self) -> tuple[int, int]:
        """(nx, ny)."""
        return self.free.shape[0], self.free.shape[1]

    def xy(self, ij: NDArray[np.integer] | tuple[int, int]) -> NDArray[np.float64]:
        """World positions (..., 2) in metres of nodes (..., 2)."""
        return np.asarray(self.origin_xy) + (np.asarray(ij, float) + 0.5) * GRID_M

    def cell(self, xy: NDArray[np.floating] | tuple[float, float]) -> tuple[int, int]:
        """The cell (i, j) that contains a world point; it may be outside the grid."""
        i, j = np.floor((np.asarray(xy, float) - self.origin_xy) / GRID_M).astype(int)
        return int(i), int(j)


@dataclass(frozen=True, eq=False)
class House(Shared):
    """A compiled home, loaded in milliseconds and shared read-only by all environments."""

    spec: HomeSpec
    """Rooms, openings and items."""
    grid: NavGrid
    """The navigation grid with everything closed."""
    boxes: NDArray[np.float64]
    """(n, 6) boxes of all instances with joints closed, x0 y0 z0 x1 y1 z1 in world metres."""

    @property
    def n_items(self) -> int:
        """Number of items of the spec."""
        return len(self.spec.items)

    @property
    def n_instances(self) -> int:
        """Number of items and pieces of structure."""
        return self.n_items + 3 * len(self.spec.rooms)

    @cached_property
    def categories(self) -> tuple[str, ...]:
        """Category of every instance."""
        return tuple(i.category for i in self.spec.items) + STRUCTURE * len(self.spec.rooms)

    @cached_property
    def instance_room(self) -> NDArray[np.int16]:
        """(n,) int16, room of every instance."""
        rooms = [i.room for i in self.spec.items] + [r for r in range(len(self.spec.rooms)) for _ in STRUCTURE]
        return np.asarray(rooms, np.int16)
