"""The state of an episode in a running PyBullet client; the same interface as :class:`SceneState`.

It is slower by orders of magnitude, and the reference that the compiled state is tested against (``world=live``). Both
follow one rule for the floor: the home's own nodes, without those within the agent's radius of a placed object's box.
Nodes under removed items stay blocked, and nobody walks under a placed object.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import SceneError
from ucon.core.geometry import matrix_from_quat
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.navgrid import AGENT_BOTTOM_M, AGENT_RADIUS_M, AGENT_TOP_M, nav_grid
from ucon.sim.robot.live_floor import LiveFloor
from ucon.sim.shapes import Array, enclosing, object_solid, primitive_boxes
from ucon.sim.world import World


class LiveState:
    """A home with one arrangement in PyBullet. Attributes as in :class:`SceneState`; close it after use."""

    def __init__(self, house: House, arrangement: Arrangement) -> None:
        self.house, self.arrangement = house, arrangement
        self.categories = house.categories + tuple(placed.category for placed in arrangement.objects)
        self._world = World(house)
        self.free: NDArray[np.bool_] = nav_grid(self._world).free.copy()
        self._world.apply(arrangement)
        self.boxes = self._world.boxes()
        self.boxes[house.n_instances :] = self._placed_boxes().reshape(-1, 6)
        self._take_nodes(self.boxes[house.n_instances :])
        present = set(self._world.instances)
        self.openable = np.array([k in present and self._jointed(k) for k in range(len(self.categories))], bool)
        self.open = np.zeros(len(self.categories), bool)
        self._floors: list[LiveFloor] = []

    def floor(self, radius_m: float, bottom_m: float, top_m: float) -> LiveFloor:
        """The floor for a robot that moves continuously; the arguments are those of :class:`LiveFloor`."""
        self._floors.append(LiveFloor(self.house, self.arrangement, radius_m, bottom_m, top_m))
        return self._floors[-1]

    def set_open(self, instance: int, is_open: bool = True) -> None:
        """Move the joints of an instance, and what its drawers hold, to open or closed."""
        self._world.set_open(instance, 1.0 if is_open else 0.0)
        self.open[instance] = self._world.openness(instance) > 0.5

    def __reduce__(self) -> Any:
        """Refuse copies: it holds a PyBullet client."""
        raise SceneError("world=live: an environment with a PyBullet client can be neither copied nor pickled")

    def close(self) -> None:
        """Disconnect all clients."""
        self._world.close()
        for floor in self._floors:
            floor.close()

    def _placed_boxes(self) -> Array:
        """Boxes (n, 6) of the parts at PyBullet's poses; PyBullet's own box of a tilted compound is too large."""
        poses, boxes = self._world.poses(), []
        for number, placed in enumerate(self.arrangement.objects):
            position, quat = poses[self.house.n_instances + number]
            turn = matrix_from_quat(np.array(quat))
            boxes.append(enclosing(primitive_boxes(object_solid(placed), np.array(position), turn)))
        return np.array(boxes)

    def _take_nodes(self, boxes: Array) -> None:
        """Block the nodes where the agent's cylinder would touch one of the boxes (n, 6)."""
        x, y = (self.house.grid.xy(np.array([[k, k] for k in range(n)]))[:, a] for a, n in enumerate(self.free.shape))
        for box in boxes:
            if box[5] <= AGENT_BOTTOM_M or box[2] >= AGENT_TOP_M:
                continue
            dx = np.maximum(np.maximum(box[0] - x, x - box[3]), 0.0)
            dy = np.maximum(np.maximum(box[1] - y, y - box[4]), 0.0)
            self.free[np.hypot(dx[:, None], dy[None, :]) < AGENT_RADIUS_M] = False

    def _jointed(self, instance: int) -> bool:
        body = self._world.bodies(instance)[0]
        return self._world.bullet.getNumJoints(body, physicsClientId=self._world.client) > 0
