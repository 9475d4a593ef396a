"""The floor in PyBullet: the reference that :class:`ucon.sim.robot.floor.Floor` is tested against."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House
from ucon.sim.robot.floor_kernels import HORIZON_M
from ucon.sim.world import World

#: Step between two distance checks where the gap to the nearest thing is smaller than this, metres.
_CREEP_M: Final = 2e-3
_HALVINGS: Final = 6
#: The robot is shortened by this at both ends: what is flush with its bottom, as a shower tray, is not touched. Metres.
_FLUSH_M: Final = 1e-3


class LiveFloor:
    """Moves a cylinder through a home in a PyBullet client of its own, where everything stays closed.

    Implements :class:`ucon.sim.robot.floor.Ground`; close it after use.
    """

    def __init__(self, house: House, arrangement: Arrangement, radius_m: float, bottom_m: float, top_m: float) -> None:
        """Build the home and the robot; the arguments are those of :class:`ucon.sim.robot.floor.Floor`."""
        self._world = World(house)
        self._world.apply(arrangement)
        floors = range(house.n_items, house.n_instances, 3)
        self._ignored = frozenset(floors)
        p, client = self._world.bullet, self._world.client
        bottom_m, top_m = bottom_m + _FLUSH_M, top_m - _FLUSH_M
        shape = p.createCollisionShape(
            p.GEOM_CYLINDER, radius=radius_m, height=top_m - bottom_m, physicsClientId=client
        )
        self._robot = p.createMultiBody(baseMass=0.0, baseCollisionShapeIndex=shape, physicsClientId=client)
        self._half = np.array([radius_m, radius_m, (top_m - bottom_m) / 2])
        self._middle_m = (bottom_m + top_m) / 2

    def close(self) -> None:
        """Disconnect the client."""
        self._world.close()

    def gap(self, x: float, y: float) -> float:
        """Metres between the robot at a point and the nearest thing, at most ``HORIZON_M``; below 0 where it touches.

        The distance is measured in space: above a doormat it is the distance to the doormat.
        """
        world, centre = self._world, np.array([x, y, self._middle_m])
        world.bullet.resetBasePositionAndOrientation(
            self._robot, tuple(centre), (0.0, 0.0, 0.0, 1.0), physicsClientId=world.client
        )
        found = world.near(self._robot, -1, centre - self._half, centre + self._half, HORIZON_M)
        return min((gap for owner, gap in found.items() if owner not in self._ignored), default=HORIZON_M)

    def free_way(self, x: float, y: float, dx: float, dy: float) -> float:
        """Metres that the robot gets along (dx, dy) from (x, y) before it touches something."""
        length = math.hypot(dx, dy)
        if length == 0.0:
            return 0.0
        ux, uy = dx / length, dy / length
        gone, here = 0.0, self.gap(x, y)
        while gone < length:
            step = min(max(here, _CREEP_M), length - gone)
            there = self.gap(x + (gone + step) * ux, y + (gone + step) * uy)
            if there < 0.0 and there < here:
                good, bad = gone, gone + step
                for _ in range(_HALVINGS):
                    middle = 0.5 * (good + bad)
                    between = self.gap(x + middle * ux, y + middle * uy)
                    if between < 0.0 and between < here:
                        bad = middle
                    else:
                        good = middle
                return good
            gone += step
            here = there
        return length
