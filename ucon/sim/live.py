"""The live state of an episode: the same facts as :class:`SceneState`, asked of a running PyBullet client.

Slower by orders of magnitude; it is the oracle that proves the compiled state right (``world=live``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.navgrid import enclosed_cells, free_cells, main_component
from ucon.sim.world import World


class LiveState:
    """A home with one arrangement in PyBullet. Attributes as in :class:`SceneState`; close it after use."""

    def __init__(self, house: House, arrangement: Arrangement) -> None:
        self.house, self.arrangement = house, arrangement
        self.categories = house.categories + tuple(placed.category for placed in arrangement.objects)
        self._world = World(house)
        self._world.apply(arrangement)
        self.boxes = self._world.boxes()
        present = set(self._world.instances)
        self.openable = np.array([k in present and self._jointed(k) for k in range(len(self.categories))], bool)
        self.open = np.zeros(len(self.categories), bool)
        grid = house.grid
        self.free: NDArray[np.bool_] = main_component(
            free_cells(self._world, grid.origin_xy, grid.room),
            house.spec.name,
            enclosed_cells(house.spec, grid.origin_xy, grid.shape),
        )

    def set_open(self, instance: int, is_open: bool = True) -> None:
        """Move the joints of an instance and what its drawers hold."""
        self._world.set_open(instance, 1.0 if is_open else 0.0)
        self.open[instance] = self._world.openness(instance) > 0.5

    def close(self) -> None:
        """Disconnect the client."""
        self._world.close()

    def _jointed(self, instance: int) -> bool:
        body = self._world.bodies(instance)[0]
        return self._world.bullet.getNumJoints(body, physicsClientId=self._world.client) > 0
