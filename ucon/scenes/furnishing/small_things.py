"""Small things of a furnished room: on tables and shelves, and on the floor along the walls."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from ucon.core.errors import ConfigError
from ucon.core.rng import stream
from ucon.objects.catalogue import catalogue
from ucon.objects.model import Vec3
from ucon.scenes.furnishing import groups as g
from ucon.scenes.furnishing.canvas import Canvas, Group, Piece
from ucon.scenes.spec import Item

LID_GAP_M = 0.10
"""Distance of chests from the wall, so that their lids open, metres."""
ON_TOP_OF: dict[str, tuple[str, ...]] = {
    "table_lamp": (
        "nightstand",
        "bottom_cabinet",
        "desk",
        "console_table",
        "drawer_unit",
        "breakfast_table",
        "coffee_table",
        "shelf",
    ),
    "monitor": ("desk", "breakfast_table", "pedestal_table", "bottom_cabinet", "bar", "reception_desk", "countertop"),
    "microwave": ("countertop", "bottom_cabinet", "breakfast_table", "console_table"),
    "pillow": ("bed", "sofa", "armchair", "bench", "garden_chair"),
    "laptop": ("desk", "breakfast_table", "coffee_table", "conference_table", "pedestal_table"),
    "burner": ("countertop", "oven"),
    "standing_tv": ("bottom_cabinet", "console_table", "desk", "breakfast_table", "coffee_table", "shelf"),
    "loudspeaker": ("bottom_cabinet", "shelf", "console_table"),
    "pot_plant": ("bottom_cabinet", "console_table", "coffee_table", "breakfast_table", "countertop"),
}
SHELVES = (
    "shelf",
    "wall_mounted_shelf",
    "grocery_shelf",
    "bottom_cabinet",
    "desk",
    "breakfast_table",
    "countertop",
    "console_table",
)
TABLEWARE = (
    "breakfast_table",
    "countertop",
    "pedestal_table",
    "coffee_table",
    "bar",
    "console_table",
    "desk",
    "conference_table",
)
GROUP_HOSTS = {
    "tableware": TABLEWARE,
    "cookware": ("countertop", "stove", "bottom_cabinet", "breakfast_table", "console_table"),
    "food": TABLEWARE,
    "stationery": ("desk", "shelf", "breakfast_table", "bottom_cabinet"),
    "electronics_small": ("desk", "breakfast_table", "bottom_cabinet", "nightstand"),
}
ON_FLOOR = (
    "cedar_chest",
    "hamper",
    "toolbox",
    "guitar",
    "toy_box",
    "storage_box",
    "wicker_basket",
    "suitcase",
    "gym_shoe",
    "sandal",
    "high_heel",
    "toy_car",
    "tennis_racket",
    "shoulder_bag",
)


def fix_noise(seed: int, room: str, key: str, n: int, scale: float) -> np.ndarray:
    """Noise (n,) that breaks ties between places of equal cost, seeded by room and key.

    Args:
        seed: of the home.
        room: its name.
        key: of what is placed.
        n: number of places.
        scale: greatest value.
    """
    return stream(seed, "fix", room, key).uniform(0.0, scale, n)


class SmallThings:
    """Puts small things in one room.

    Attributes:
        missing: by category, how many found no place.
    """

    def __init__(self, canvas: Canvas, seed: int, name: str) -> None:
        self.canvas, self.seed, self.name = canvas, seed, name
        self.missing: Counter[str] = Counter()

    def _noise(self, key: str, n: int, scale: float) -> np.ndarray:
        return fix_noise(self.seed, self.name, key, n, scale)

    def put(self, wants: Mapping[str, int]) -> None:
        """Put small things on tops, on shelves, or on the floor along the walls.

        Args:
            wants: by category, how many.
        """
        for category in sorted(wants):
            if category not in catalogue():
                continue
            for k in range(wants[category]):
                if (
                    not (category in ON_FLOOR and self._on_floor(category, k))
                    and not self._on_top(category, k)
                    and not self._on_floor(category, k)
                ):
                    self.missing[category] += wants[category] - k
                    break

    def _on_floor(self, category: str, k: int) -> bool:
        size = g.size_of(category)
        if size[2] < 0.1 and category not in ON_FLOOR:
            return False
        group = g.single(category, size)
        poses = self.canvas.wall_poses(group, (0, 1, 2, 3), LID_GAP_M)
        return self.canvas.try_place(group, poses, self._noise(f"floor/{category}/{k}", len(poses), 5.0))

    def hosts(self, category: str) -> list[int]:
        """Numbers of the room's items that a category may be put on, the best first."""
        row = catalogue()[category]
        names = ON_TOP_OF.get(category)
        if names is None:
            names = next(
                (v for key, v in GROUP_HOSTS.items() if row.semantic_group.startswith(key)), SHELVES + TABLEWARE
            )
        order = {name: rank for rank, name in enumerate(dict.fromkeys(names))}
        found = [i for i, item in enumerate(self.canvas.items) if item.category in order]
        noise = self._noise(f"host/{category}", len(found) + 1, 2.5)
        return [i for _, i in sorted((order[self.canvas.items[i].category] + noise[n], i) for n, i in enumerate(found))]

    def _on_top(self, category: str, k: int) -> bool:
        size = g.size_of(category)
        turn_rng = stream(self.seed, "top", self.name, category, k)
        for index in self.hosts(category):
            host = self.canvas.items[index]
            for surface in tops(host.category, host.size):
                if self._on_surface(category, size, index, host, surface, turn_rng):
                    return True
        return False

    def _on_surface(
        self,
        category: str,
        size: Vec3,
        index: int,
        host: Item,
        surface: tuple[float, float, float, float, float, float],
        rng: np.random.Generator,
    ) -> bool:
        x0, y0, x1, y1, z, clearance = surface
        if size[2] > clearance - 0.01 or size[0] > x1 - x0 - 0.01 or size[1] > y1 - y0 - 0.01:
            return False
        xs = np.linspace(x0 + size[0] / 2 + 0.005, x1 - size[0] / 2 - 0.005, max(1, int((x1 - x0 - size[0]) / 0.1) + 1))
        ys = np.linspace(y0 + size[1] / 2 + 0.005, y1 - size[1] / 2 - 0.005, max(1, int((y1 - y0 - size[1]) / 0.1) + 1))
        spots = np.array([(x, y) for x in xs for y in ys])
        behind = category in ("monitor", "standing_tv", "table_lamp", "microwave", "coffee_maker", "pillow")
        order = np.argsort(
            spots[:, 0] * 4 + np.abs(spots[:, 1]) + rng.uniform(0, 0.2, len(spots))
            if behind
            else rng.uniform(0, 1, len(spots))
        )
        group = Group([Piece(category, size, 0.0, 0.0, z, tint=int(rng.integers(0, 6)))], margin_m=0.0)
        c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[host.quarter_turns]
        px, py, pz = host.position
        group.pieces[0].z = pz + z + 0.001
        if catalogue()[category].openable and size[2] > 0.15:
            if category != "microwave":
                return False  # its inside could not be seen
            low, half = pz + z + 0.001, size[1] / 2  # its door swings over the edge
            group.voids.append((size[0] / 2, -half, low, size[0] / 2 + 0.5, half, low + size[2]))
        poses = np.array([(px + c * x - s * y, py + s * x + c * y, host.quarter_turns) for x, y in spots[order]], float)
        return self._settle(group, poses, index)

    def _settle(self, group: Group, poses: np.ndarray, host: int) -> bool:
        """Like ``try_place``, but inside the host's box and without regard to clear spaces, since it blocks no path."""
        canvas = self.canvas
        voids, free, box = canvas.voids, canvas.free.copy(), canvas.solids[host].copy()
        canvas.voids, canvas.solids[host] = canvas.sweeps, 0.0
        done = canvas.try_place(group, poses, np.arange(len(poses), dtype=float), walkable=False)
        canvas.voids, canvas.free, canvas.solids[host] = voids, free, box
        return done


def tops(category: str, size: Vec3) -> list[tuple[float, float, float, float, float, float]]:
    """Surfaces of an item that do not move with a joint.

    Args:
        category: of the item.
        size: metres.

    Returns:
        (x0, y0, x1, y1, z, clearance) of each in the object frame, metres.
    """
    from ucon.objects.models import build_model

    try:
        surfaces = build_model(category, size).surfaces
    except (ConfigError, NotImplementedError, ImportError):
        surfaces = ()
    return [(s.x0, s.y0, s.x1, s.y1, s.z, s.clearance_m) for s in surfaces if s.link < 0]
