"""Ways of placing a group: at walls, in corners, in the middle, facing something; all seeded by room and item."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from ucon.core.rng import stream
from ucon.objects.catalogue import catalogue
from ucon.scenes.furnishing import groups as g
from ucon.scenes.furnishing.canvas import Canvas, Group

HALL_M2, SPREAD_M = 40.0, 9.0
"""In rooms larger than ``HALL_M2``, noise of up to ``SPREAD_M`` spreads the tables over the floor."""


class Placer:
    """A canvas, the list of what it should hold, and seeded ways of placing a group.

    Attributes:
        canvas: the room.
        type: of the room.
        wants: by category, how many are still to be placed.
        tint: colour variant of the room's furniture.
    """

    def __init__(self, canvas: Canvas, room_type: str, wants: Mapping[str, int], seed: int, name: str) -> None:
        """Start with an empty canvas.

        Args:
            canvas: the room.
            room_type: its type.
            wants: by category, how many it should hold; unknown categories are left out.
            seed: of the home.
            name: of the room.
        """
        self.canvas = canvas
        self.type = room_type
        self.wants: Counter[str] = Counter({k: wants[k] for k in sorted(wants) if k in catalogue()})
        self.seed, self.name = seed, name
        self.tint = int(stream(seed, "tint", name).integers(0, 6))

    # -- placing helpers --------------------------------------------------------------------------------------

    def take(self, category: str, n: int = 1) -> None:
        """Remove ``n`` items of a category from ``wants``."""
        self.wants[category] -= n
        if self.wants[category] <= 0:
            del self.wants[category]

    def noise(self, key: str, n: int, scale: float) -> np.ndarray:
        """Uniform noise (n,) from 0 to ``scale`` for the poses of one group, seeded by its key."""
        return stream(self.seed, "pose", self.name, key).uniform(0.0, scale, n)

    def wall(
        self,
        group: Group,
        key: str,
        prefer: str = "any",
        walls: tuple[int, ...] = (0, 1, 2, 3),
        gap_m: float = g.WALL_GAP_M,
    ) -> bool:
        """Place a group at a wall.

        Args:
            group: the group.
            key: of its random numbers.
            prefer: ``any``, ``middle``, ``corner`` or ``edge``.
            walls: their numbers.
            gap_m: distance from the wall.

        Returns:
            Whether there was a place.
        """
        poses = self.canvas.wall_poses(group, walls, gap_m)
        if not len(poses):
            return False
        cost = self.noise(key, len(poses), 0.8)
        along = np.where(poses[:, 2] % 2 == 0, poses[:, 1], poses[:, 0])
        for wall in walls:
            rows = poses[:, 2] == wall
            if not rows.any():
                continue
            low, high = along[rows].min(), along[rows].max()
            cost[rows] += float(self.noise(f"{key}/{wall}", 1, 1.5)[0])
            if prefer == "corner":
                cost[rows] += 3.0 * np.minimum(along[rows] - low, high - along[rows])
            elif prefer == "middle":
                cost[rows] += 1.5 * np.abs(along[rows] - (low + high) / 2)
            elif prefer == "edge":
                cost[rows] += 1.0 * np.minimum(along[rows] - low, high - along[rows])
        same = [i.position for i in self.canvas.items if i.category == group.pieces[0].category]
        if same and prefer in ("corner", "edge") and not key.startswith("run/"):  # spread plants and lamps out
            apart = np.hypot(poses[:, None, 0] - [p[0] for p in same], poses[:, None, 1] - [p[1] for p in same]).min(1)
            cost -= 0.6 * np.minimum(apart, 2.0)
        if prefer == "middle":
            cost -= 0.35 * self._door_distance(poses)
        return self.canvas.try_place(group, poses, cost)

    def _door_distance(self, poses: np.ndarray) -> np.ndarray:
        nodes = self.canvas.door_nodes
        if not nodes:
            return np.zeros(len(poses))
        xy = np.array([(self.canvas.nodes_x[i], self.canvas.nodes_y[j]) for i, j in nodes])
        return np.hypot(poses[:, None, 0] - xy[:, 0], poses[:, None, 1] - xy[:, 1]).min(1)

    def middle(
        self, group: Group, key: str, target: tuple[float, float] | None = None, turns: tuple[int, ...] = (0, 1)
    ) -> bool:
        """Place a group on the floor.

        Args:
            group: the group.
            key: of its random numbers.
            target: point to be near; the middle of the room by default.
            turns: quarter turns to try.

        Returns:
            Whether there was a place.
        """
        poses = self.canvas.free_poses(turns)
        x0, y0, x1, y1 = self.canvas.inner
        tx, ty = target or ((x0 + x1) / 2, (y0 + y1) / 2)
        spread = SPREAD_M if (x1 - x0) * (y1 - y0) > HALL_M2 and key.startswith("table/") else 0.4
        cost = np.hypot(poses[:, 0] - tx, poses[:, 1] - ty) + self.noise(key, len(poses), spread)
        return self.canvas.try_place(group, poses, cost)

    def facing(self, group: Group, key: str, target: tuple[float, float], apart_m: float) -> bool:
        """Place a seat so that it faces a point.

        Args:
            group: the seat.
            key: of its random numbers.
            target: the point, metres.
            apart_m: preferred distance.

        Returns:
            Whether there was a place.
        """
        poses = self.canvas.free_poses((0, 1, 2, 3))
        dx, dy = target[0] - poses[:, 0], target[1] - poses[:, 1]
        away = np.hypot(dx, dy)
        turn = poses[:, 2].astype(int)
        look = (np.array([1, 0, -1, 0])[turn] * dx + np.array([0, 1, 0, -1])[turn] * dy) / np.maximum(away, 0.1)
        cost = np.abs(away - apart_m) + 3.0 * (1 - look) + self.noise(key, len(poses), 0.3)
        keep = look > 0.7
        return self.canvas.try_place(group, poses[keep], cost[keep])

    def place_each(self, category: str, group: Group, prefer: str, key: str = "", limit: int = 99) -> None:
        """Place all wanted items of a category at walls, until one finds no place.

        Args:
            category: of the items.
            group: one of them.
            prefer: see :meth:`wall`.
            key: prefix of the key of the random numbers.
            limit: most items.
        """
        for k in range(min(self.wants[category], limit)):
            if not self.wall(group, f"{key}{category}/{k}", prefer):
                break
            self.take(category)

    def _count(self, group: Group) -> None:
        for piece in group.pieces:
            if self.wants[piece.category] > 0:
                self.take(piece.category)
