"""Furnishing of one room: turns the list of what it should hold into placed groups.

The list decides which groups are built (a bed gets its nightstands wherever it is); the room's type only decides how
tables are used. Necessary things come before extras. What finds no place is reported, never forced in.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from ucon.core.rng import stream
from ucon.objects.catalogue import catalogue
from ucon.objects.model import Vec3
from ucon.scenes.furnishing import groups as g
from ucon.scenes.furnishing.canvas import Group, Piece
from ucon.scenes.furnishing.seating import SEATS, TablePlacer

BED_SIZES: tuple[Vec3, ...] = ((2.0, 1.6, 0.9), (2.0, 1.4, 0.9), (1.95, 1.2, 0.85), (1.9, 0.95, 0.8))
NIGHTSTAND: dict[str, Vec3] = {
    "nightstand": (0.42, 0.5, 0.55),
    "bottom_cabinet": (0.42, 0.5, 0.55),
    "drawer_unit": (0.42, 0.5, 0.6),
}
CARPETS: tuple[Vec3, ...] = (
    (1.6, 2.4, g.CARPET_M),
    (1.4, 2.0, g.CARPET_M),
    (1.0, 1.5, g.CARPET_M),
    (0.7, 1.1, g.CARPET_M),
)
SMALL_CARPETS: dict[str, tuple[Vec3, ...]] = {
    "bathroom": ((0.6, 0.9, g.CARPET_M), (0.45, 0.7, g.CARPET_M)),
    "corridor": ((0.8, 2.2, g.CARPET_M), (0.7, 1.1, g.CARPET_M)),
    "entryway": ((0.7, 1.1, g.CARPET_M), (0.5, 0.8, g.CARPET_M)),
    "kitchen": ((0.7, 1.4, g.CARPET_M),),
}
"""Mats and runners."""
AISLE_M = 1.3


class Furnisher(TablePlacer):
    """Furnishes one canvas; what is left in ``wants`` at the end found no place."""

    # -- the order of work ------------------------------------------------------------------------------------

    def run(self) -> Counter[str]:
        """Furnish the floor.

        Returns:
            By category, how many found no place.
        """
        self.counters()
        self.bath()
        self.beds()
        self.laundry()
        self.shop()
        self.media()
        self.tables()
        self.storage()
        self.loose_seats()
        self.large()
        self.small_floor()
        self.carpets()
        return self.wants

    def bath(self) -> None:
        """Place tub and shower in corners, the rest along the walls, and a mirror above every sink."""
        w = self.wants
        if w["bathtub"]:
            for size in ((1.7, 0.8, 0.6), (1.5, 0.7, 0.6)):
                self.place_each("bathtub", g.single("bathtub", size, turns=1, clear_m=0.4), "corner")
        if w["shower_stall"]:
            for size in ((0.95, 0.95, 2.05), (0.85, 0.85, 2.05)):
                self.place_each("shower_stall", g.single("shower_stall", size, clear_m=0.4), "corner")
        if w["shower"]:
            self.place_each("shower", g.single("shower", (0.95, 0.95, 0.09)), "corner")
        self.place_each("toilet", g.single("toilet", clear_m=0.5), "edge")
        self.place_each("bidet", g.single("bidet", clear_m=0.4), "edge")
        for k in range(w["sink"]):
            mirror = w["mirror"] > 0 and self.type == "bathroom"
            sizes: tuple[Vec3, ...] = ((0.5, 0.62, 0.86), (0.42, 0.5, 0.86))
            for size in sizes:
                group = g.single("sink", size, clear_m=0.5)
                if mirror:
                    m = g.size_of("mirror")
                    group.pieces.append(Piece("mirror", m, m[0] / 2 - g.WALL_GAP_M, 0.0, 1.0))
                if self.wall(group, f"sink/{k}", "any"):
                    self._count(group)
                    break

    def beds(self) -> None:
        """Place beds with nightstands at their sides."""
        kinds = [c for c in ("bed", "crib") for _ in range(self.wants[c])]
        for k, kind in enumerate(kinds):
            child = self.type == "childs_room" or len(kinds) > 1
            sizes = ((1.3, 0.7, 1.0),) if kind == "crib" else (BED_SIZES[2:] if child else BED_SIZES)
            stands = [c for c in ("nightstand", "bottom_cabinet", "drawer_unit") for _ in range(min(2, self.wants[c]))]
            stands = [] if kind == "crib" else stands[:2]
            if self._place_bed(kind, sizes, stands, f"bed/{k}"):
                self.take(kind)

    def _place_bed(self, kind: str, sizes: tuple[Vec3, ...], stands: list[str], key: str) -> bool:
        flip = bool(stream(self.seed, "flip", self.name).random() < 0.5)
        for n in range(len(stands), -1, -1):
            for size in sizes:
                sides = [(c, NIGHTSTAND[c]) for c in stands[:n]] + [None] * (2 - n)
                left, right = (sides[1], sides[0]) if flip else (sides[0], sides[1])
                group = g.bed(size, left, right, self.tint, kind)
                if self.wall(group, key, "middle" if n else "corner"):
                    for c in stands[:n]:
                        self.take(c)
                    return True
        return False

    def laundry(self) -> None:
        """Place washer and dryer side by side."""
        if self.wants["washer"] and self.wants["clothes_dryer"]:
            pair = [("washer", g.size_of("washer")), ("clothes_dryer", g.size_of("clothes_dryer"))]
            tops = ["top_cabinet"] * min(2, self.wants["top_cabinet"])
            group = g.counter_run(pair, False, tops, self.tint)
            if self.wall(group, "laundry", "corner"):
                self._count(group)
        for category in ("washer", "clothes_dryer"):
            self.place_each(category, g.single(category), "corner")

    def shop(self) -> None:
        """Place shop shelves: rows with aisles in the middle, the rest along the walls."""
        n = self.wants["grocery_shelf"]
        size = (0.6, 1.7, 1.9)
        for row in range(4):  # whole double rows first, the rest along the walls
            group = g.shelf_row("grocery_shelf", size, 6, self.tint, AISLE_M)
            if n < 8 or not self.middle(group, f"row/{row}"):
                break
            self.take("grocery_shelf", 6)
            n -= 6
        self.place_each("checkout_counter", g.single("checkout_counter", turns=1, clear_m=0.8), "edge")
        self.place_each("grocery_shelf", g.single("grocery_shelf", size, clear_m=1.0), "edge")

    def media(self) -> None:
        """Place a television at a wall and a sofa that faces it; other sofas at walls."""
        w = self.wants
        tv = next((c for c in ("wall_mounted_tv", "standing_tv") if w[c]), None)
        spot = None
        if tv and self.type not in ("shared_office", "bar", "conference_hall", "break_room", "lobby"):
            spot = self._place_tv(tv)
        for k in range(w["sofa"]):
            if not self._place_sofa(spot if k == 0 else None, k):
                break
        centre = self._centre_of("coffee_table") or self._centre_of("sofa")
        for category in ("armchair", "eames_chair", "ottoman"):
            if centre and self.type not in ("dining_room", "garden"):
                for k in range(w[category]):
                    group = g.single(category)
                    group.pieces[0].x = 0.0
                    if not self.facing(group, f"{category}/{k}", centre, 1.2):
                        break
                    self.take(category)

    def _place_tv(self, tv: str) -> tuple[float, float, int] | None:
        w = self.wants
        stand = next((c for c in ("bottom_cabinet", "console_table", "coffee_table", "breakfast_table") if w[c]), None)
        sizes: dict[str, Vec3] = {"bottom_cabinet": (0.45, 1.4, 0.5), "console_table": (0.4, 1.3, 0.55)}
        options: list[tuple[str, Vec3] | None] = [(stand, sizes.get(stand, (0.5, 1.1, 0.5)))] if stand else []
        if tv == "wall_mounted_tv":
            options.append(None)
        for option in options or [None]:
            group = g.media(tv, option, w["loudspeaker"], self.tint)
            if self.wall(group, "tv", "middle"):
                self._count(group)
                item = next(i for i in reversed(self.canvas.items) if i.category == tv)
                return item.position[0], item.position[1], item.quarter_turns
        return None

    def _place_sofa(self, tv: tuple[float, float, int] | None, k: int) -> bool:
        w = self.wants
        table = "coffee_table" if w["coffee_table"] else None
        small = self.canvas.wall_length(0) * self.canvas.wall_length(1) < 16
        carpets = ((1.6, 2.4, g.CARPET_M), (1.4, 2.0, g.CARPET_M)) if w["carpet"] and k == 0 else ()
        for length in (2.0, 1.6) if small or k else (2.2, 1.8, 1.6):
            for carpet in (*carpets, None):
                for low in dict.fromkeys((table, None)):
                    group = g.sofa_set("sofa", (0.9, length, 0.8), low, (0.6, 1.0, 0.43), carpet, self.tint)
                    if self._sofa_pose(group, tv, f"sofa/{k}"):
                        self._count(group)
                        return True
        return False

    def _sofa_pose(self, group: Group, tv: tuple[float, float, int] | None, key: str) -> bool:
        if tv is None:
            return self.wall(group, key, "middle")
        turn = (tv[2] + 2) % 4
        poses = np.vstack([self.canvas.wall_poses(group, (turn,), g.WALL_GAP_M), self.canvas.free_poses((turn,))])
        axis = 0 if turn % 2 == 0 else 1
        apart = np.abs(poses[:, axis] - tv[axis]) - 0.9
        cost = 2.0 * np.abs(poses[:, 1 - axis] - tv[1 - axis]) + np.abs(apart - 2.7) + self.noise(key, len(poses), 0.1)
        cost[: len(poses) - len(self.canvas.free_poses((turn,)))] -= 0.8
        keep = (apart > 1.4) & (apart < 4.5)
        return self.canvas.try_place(group, poses[keep], cost[keep])

    def _centre_of(self, category: str) -> tuple[float, float] | None:
        item = next((i for i in self.canvas.items if i.category == category), None)
        return (item.position[0], item.position[1]) if item else None

    def storage(self) -> None:
        """Place cabinets, shelves and wardrobes along free walls."""
        small: dict[str, Vec3] = {
            "wardrobe": (0.55, 1.0, 2.05),
            "shelf": (0.3, 0.6, 1.5),
            "bottom_cabinet": (0.4, 0.6, 0.75),
        }
        for category in (
            "wardrobe",
            "shelf",
            "bottom_cabinet",
            "drawer_unit",
            "display_case",
            "bottom_cabinet_no_top",
            "nightstand",
        ):
            clear = 0.55 if category in ("shelf", "display_case") else 0.0
            self.place_each(category, g.single(category, tint=self.tint, clear_m=clear), "edge")
            if self.wants[category] and category in small:
                self.place_each(
                    category, g.single(category, small[category], tint=self.tint, clear_m=clear), "edge", "small/"
                )

    def loose_seats(self) -> None:
        """Place chairs that found no table at walls."""
        for category in (*SEATS, "ottoman", "bench", "sauna_bench"):
            self.place_each(category, g.single(category, tint=self.tint, clear_m=0.35), "edge", limit=8)
            self.place_each(category, g.single(category, tint=self.tint), "corner", "tight/", limit=4)

    def large(self) -> None:
        """Place other large things: at a wall, else in the middle."""
        rest = [c for c in self.wants if catalogue()[c].mount == "floor" and c != "carpet"]
        rest = [c for c in rest if np.prod(g.size_of(c)[:2]) >= 0.25]
        self._islands(rest)
        rest = [c for c in rest if self.wants[c]]
        roomy = self.canvas.wall_length(0) * self.canvas.wall_length(1) > 20
        for category in sorted(rest, key=lambda c: (-float(np.prod(g.size_of(c)[:2])), c)):
            size = g.size_of(category)
            turn = 1 if size[0] > size[1] * 1.3 and category not in ("treadmill", "toilet") else 0
            for k in range(self.wants[category]):
                open_floor = category in ("pool_table", "car", "swimming_pool", "playground", "sandbox", "hammock")
                group = g.single(category, tint=self.tint, turns=turn, clear_m=0.4 if not open_floor else 0.0)
                key = f"large/{category}/{k}"
                if open_floor:
                    middle = g.single(category, tint=self.tint)
                    middle.pieces[0].x = 0.0
                    done = self.middle(middle, key) or self.wall(group, key, "edge")
                else:
                    done = self.wall(group, key, "edge") or (roomy and self.middle(group, key, turns=(0, 1, 2, 3)))
                if not done:
                    break
                self.take(category)

    def small_floor(self) -> None:
        """Place lamps, plants and bins in corners."""
        rest = [
            c for c in self.wants if catalogue()[c].mount == "floor" and c not in ("carpet", "table_lamp", "monitor")
        ]
        for category in sorted(rest):
            if category in ("standing_tv",):
                continue
            self.place_each(category, g.single(category, tint=self.tint), "corner", limit=12)

    def carpets(self) -> None:
        """Place carpets in the middle, under the furniture."""
        for k in range(self.wants["carpet"]):
            for size in SMALL_CARPETS.get(self.type, CARPETS if k == 0 else CARPETS[2:]):
                group = Group([Piece("carpet", size, 0.0, 0.0, tint=self.tint + k)], margin_m=0.1)
                if self.middle(group, f"carpet/{k}"):
                    self.take("carpet")
                    break
