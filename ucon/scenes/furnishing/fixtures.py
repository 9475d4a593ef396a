"""Fixtures: what hangs on walls and ceilings, and door frames."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ucon.objects.catalogue import catalogue
from ucon.objects.model import Vec3
from ucon.scenes.furnishing import groups as g
from ucon.scenes.furnishing.canvas import Canvas, Group, Piece
from ucon.scenes.furnishing.small_things import fix_noise
from ucon.scenes.spec import LINTEL_M, Item, Opening

HANG_CLEAR_M = 0.30
"""Nothing tall stands closer than this in front of a picture or window, metres."""
FRAME_DEPTH_M = 0.12
HEIGHTS_M = {"picture": 1.35, "painting": 1.3, "poster": 1.2, "mirror": 1.0, "electric_switch": 1.1, "window": 0.9}
LIGHTS = ("room_light", "chandelier", "downlight", "square_light")


def door_frame(opening: Opening, room: int, tint: int) -> Item:
    """The frame in a doorway; its middle is free.

    Args:
        opening: the doorway.
        room: number of the room it belongs to.
        tint: colour variant.
    """
    middle = (opening.lo + opening.hi) / 2
    x, y = (opening.coord, middle) if opening.axis == 0 else (middle, opening.coord)
    size = (FRAME_DEPTH_M, opening.hi - opening.lo, min(LINTEL_M, opening.height_m))
    return Item("door", size, (x, y, 0.0), 0 if opening.axis == 0 else 1, room, tint)


class Fixer:
    """Hangs fixtures in one room.

    Attributes:
        missing: by category, how many found no place.
    """

    def __init__(self, canvas: Canvas, exterior: list[tuple[int, float, float]], seed: int, name: str) -> None:
        """Take over a room.

        Args:
            canvas: the room.
            exterior: (wall, lo, hi) of its outside walls.
            seed: of the home.
            name: of the room.
        """
        self.canvas, self.exterior, self.seed, self.name = canvas, exterior, seed, name
        self.missing: Counter[str] = Counter()

    def _noise(self, key: str, n: int, scale: float) -> np.ndarray:
        return fix_noise(self.seed, self.name, key, n, scale)

    # -- walls ------------------------------------------------------------------------------------------------

    def windows(self, n: int) -> None:
        """Hang up to ``n`` windows, spread over the outside walls."""
        if self.canvas.wall_height_m < 2.3:
            return
        for k in range(n):
            placed = any(self._window(k, size) for size in ((0.04, 1.3, 1.3), (0.04, 0.8, 1.3)))
            if not placed:
                self.missing["window"] += n - k
                return

    def _window(self, k: int, size: Vec3) -> bool:
        group = self._hung("window", size, HEIGHTS_M["window"])
        group.margin_m = 0.3
        poses = self.canvas.wall_poses(group, (0, 1, 2, 3), 0.0)
        if not len(poses):
            return False
        along = np.where(poses[:, 2] % 2 == 0, poses[:, 1], poses[:, 0])
        keep = np.zeros(len(poses), bool)
        cost = self._noise(f"window/{k}", len(poses), 0.2)
        for wall, lo, hi in self.exterior:
            rows = (poses[:, 2] == wall) & (along - size[1] / 2 >= lo + 0.1) & (along + size[1] / 2 <= hi - 0.1)
            keep |= rows
            taken = sum(1 for i in self.canvas.items if i.category == "window" and i.quarter_turns == wall)
            cost[rows] += np.abs(along[rows] - (lo + hi) / 2) * 0.5 - 0.2 * (hi - lo) + 1.5 * taken
        return self.canvas.try_place(group, poses[keep], cost[keep])

    def _hung(self, category: str, size: Vec3, z: float, tint: int = 0) -> Group:
        group = Group([Piece(category, size, size[0] / 2, 0.0, z, tint=tint)])
        reach = size[0] + HANG_CLEAR_M
        group.voids.append((0.0, -size[1] / 2, max(z, 0.3), reach, size[1] / 2, z + size[2]))
        return group

    def hang(self, category: str, n: int) -> None:
        """Hang ``n`` items of a category on free pieces of wall."""
        base = catalogue()[category]
        size = g.size_of(category)
        if category in ("wall_mounted_shelf", "top_cabinet"):
            size = (size[0], min(size[1], 0.8), size[2])
        z = HEIGHTS_M.get(category, base.bottom_z_m)
        z = min(z, self.canvas.wall_height_m - size[2] - 0.02)
        for k in range(n):
            tint = int(self._noise(f"tint/{category}/{k}", 1, 6.0)[0])
            group = self._hung(category, size, z, tint)
            if base.openable:
                box = (0.0, -size[1] / 2, z, size[0], size[1] / 2, z + size[2])
                group.fronts.append(g.front_rect(box))
                group.voids = [g.front_void(box, max(0.45, g.leaf_m(size[1])))]
                group.margin_m = 0.12
            poses = self.canvas.wall_poses(group, (0, 1, 2, 3), 0.0)
            if not len(poses):
                self.missing[category] += n - k
                return
            cost = self._noise(f"{category}/{k}", len(poses), 3.0)
            if category == "radiator":  # under windows
                panes = [i for i in self.canvas.items if i.category == "window"]
                for pane in panes:
                    cost -= 2.0 * (np.hypot(*(poses[:, :2] - pane.position[:2]).T) < 0.4)
            if category in ("top_cabinet", "wall_mounted_shelf"):
                cost -= 2.0 * self._over_furniture(poses)
            if not self.canvas.try_place(group, poses, cost):
                self.missing[category] += n - k
                return

    def _over_furniture(self, poses: np.ndarray) -> np.ndarray:
        """1 for poses above low furniture, else 0; (n,)."""
        low = [b for b in self.canvas.solids if b[2] == 0 and 0.3 < b[5] < 1.2]
        hit = np.zeros(len(poses))
        for b in low:
            near = (poses[:, 0] > b[0] - 0.4) & (poses[:, 0] < b[3] + 0.4)
            hit[near & (poses[:, 1] > b[1] - 0.4) & (poses[:, 1] < b[4] + 0.4)] = 1.0
        return hit

    def switches(self, n: int) -> None:
        """Put ``n`` switches beside the openings."""
        size = g.size_of("electric_switch")
        done = 0
        for k, (wall, lo, hi) in enumerate(self.canvas.doors):
            if done >= n:
                return
            for at in (hi + 0.2, lo - 0.2, hi + 0.35, lo - 0.35):
                x0, y0, x1, y1 = self.canvas.inner
                pose = {0: (x0, at, 0), 1: (at, y0, 1), 2: (x1, at, 2), 3: (at, y1, 3)}[wall]
                group = Group([Piece("electric_switch", size, size[0] / 2, 0.0, HEIGHTS_M["electric_switch"])])
                if self.canvas.try_place(group, np.array([pose], float), np.zeros(1)):
                    done += 1
                    break
            del k
        self.missing["electric_switch"] += max(0, n - done)

    # -- ceiling ----------------------------------------------------------------------------------------------

    def lights(self, category: str, n: int) -> None:
        """Put ``n`` lamps under the ceiling: one in the middle, several in a line."""
        x0, y0, x1, y1 = self.canvas.inner
        size = g.size_of(category)
        if category == "room_light":
            size = (min(size[0], 0.4), min(size[1], 0.4), 0.25)
        if category == "chandelier":
            size = (0.6, 0.6, min(0.5, self.canvas.wall_height_m - 1.95))
        wide = x1 - x0 >= y1 - y0
        for k in range(n):
            t = (k + 0.5) / n
            x, y = (x0 + t * (x1 - x0), (y0 + y1) / 2) if wide else ((x0 + x1) / 2, y0 + t * (y1 - y0))
            group = Group([Piece(category, size, 0.0, 0.0, self.canvas.wall_height_m - size[2])], margin_m=0.05)
            near = np.array([(x + dx, y + dy, 0) for dx in (0, -0.5, 0.5) for dy in (0, -0.5, 0.5)], float)
            if not self.canvas.try_place(group, near, np.arange(len(near), dtype=float)):
                self.missing[category] += 1
