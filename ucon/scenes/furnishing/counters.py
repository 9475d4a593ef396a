"""Kitchens and bathrooms: runs of counter units, straight or around a corner, and islands."""

from __future__ import annotations

import numpy as np

from ucon.scenes.furnishing import groups as g
from ucon.scenes.furnishing.placer import Placer


class CounterPlacer(Placer):
    """Places everything that stands in a counter run."""

    def counters(self) -> None:
        """Place counter runs: straight where they fit, else around a corner, else unit by unit."""
        w = self.wants
        kitchen = bool(w["fridge"] or w["oven"] or w["stove"] or w["dishwasher"]) or self.type in (
            "kitchen",
            "pantry_room",
        )
        if not kitchen and not w["bottom_cabinet_no_top"]:
            return
        units = self._units(kitchen)
        if not units:
            return
        slabs = w["countertop"] > 0
        tops = ["range_hood"] * w["range_hood"] + ["top_cabinet"] * w["top_cabinet"]
        self._place_run(units, slabs, tops, 0)

    def _units(self, kitchen: bool) -> list[g.Unit]:
        w = self.wants
        depth = g.RUN_DEPTH_M
        wide = 0.6 if self.canvas.wall_length(0) * self.canvas.wall_length(1) < 16 else 0.7
        cab: g.Unit = ("bottom_cabinet_no_top", (depth, wide, 0.86))
        sink: g.Unit = ("sink", (depth, 0.62, 0.9))
        wash: list[g.Unit] = [sink] * (w["sink"] if w["bottom_cabinet_no_top"] or kitchen else 0)
        wash += [("dishwasher", (depth, 0.6, 0.83))] * w["dishwasher"]
        heat: list[g.Unit] = [("stove", (depth, 0.68, 0.9))] * w["stove"] + [("oven", (depth, 0.6, 0.88))] * w["oven"]
        cabs = [cab] * w["bottom_cabinet_no_top"]
        if kitchen and not cabs:
            cabs = [("bottom_cabinet", (depth, 0.7, 0.85))] * w["bottom_cabinet"]
        if w["countertop"] > 0 and not w["bottom_cabinet_no_top"]:
            cabs += [("countertop", (0.62, 1.0, g.COUNTER_M))] * min(2, w["countertop"])
        cabs += [("metal_bottom_cabinet", (0.62, 1.2, 0.9))] * w["metal_bottom_cabinet"]
        a, b = len(cabs) // 3, len(cabs) - len(cabs) // 3
        fridges: list[g.Unit] = [("fridge", g.size_of("fridge"))] * w["fridge"]
        return fridges + cabs[:a] + wash + cabs[a : (a + b) // 2 + a // 2] + heat + cabs[(a + b) // 2 + a // 2 :]

    def _place_run(self, units: list[g.Unit], slabs: bool, tops: list[str], depth: int) -> None:
        length = sum(u[1][1] + g.SIDE_M for u in units)
        key = f"run/{depth}/{len(units)}/{units[0][0]}"
        longest = max(self.canvas.wall_length(0), self.canvas.wall_length(1))
        if length <= longest - 0.3:
            left = list(tops)
            group = g.counter_run(units, slabs, left, self.tint)
            if self.wall(group, key, "corner"):
                self._count(group)
                tops[:] = left
                return
        if len(units) >= 3 and slabs and self._corner_run(units, slabs, tops, key):
            return
        if len(units) > 1:
            half = len(units) // 2
            self._place_run(units[:half], slabs, tops, 2 * depth + 1)
            self._place_run(units[half:], slabs, tops, 2 * depth + 2)

    def _corner_run(self, units: list[g.Unit], slabs: bool, tops: list[str], key: str) -> bool:
        x0, y0, x1, y1 = self.canvas.inner
        e = g.WALL_GAP_M
        poses = np.array([(x0 + e, y0 + e, 0), (x1 - e, y0 + e, 1), (x1 - e, y1 - e, 2), (x0 + e, y1 - e, 3)])
        splits = sorted(range(1, len(units)), key=lambda k: abs(2 * k - len(units)))
        for split in splits[:5]:
            for flip in (False, True):
                first, second = units[:split][::-1], units[split:]
                left = list(tops)
                pair = (second, first) if flip else (first, second)
                group = g.counter_corner(pair[0], pair[1], slabs, left, self.tint)
                if self.canvas.try_place(group, poses, self.noise(f"{key}/{split}/{flip}", 4, 1.0)):
                    self._count(group)
                    tops[:] = left
                    return True
        return False

    def _islands(self, rest: list[str]) -> None:
        """Place lines of appliances in the middle of a large kitchen."""
        if self.type != "kitchen" or self.canvas.wall_length(0) * self.canvas.wall_length(1) < 30:
            return
        units = [(c, g.size_of(c)) for c in sorted(rest) for _ in range(self.wants[c])]
        for k in range(0, len(units) - 1, 4):
            group = g.counter_run(units[k : k + 4], False, [], self.tint)
            group.margin_m = 0.6
            if self.middle(group, f"island/{k}", turns=(0, 1, 2, 3)):
                self._count(group)
