"""A home of boxes seen with a small ray caster: the environment's contract without the simulator."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

CELL = 0.25


@dataclass
class Thing:
    category: str
    box: tuple[float, float, float, float, float, float]
    container: int = -1


@dataclass
class ToyHome:
    """A rectangular home [0, w] x [0, d] with interior walls and things; the floor is at 0, the ceiling at 2.4."""

    width: float
    depth: float
    things: list[Thing]
    walls: list[tuple[float, float, float, float]] = field(default_factory=list)

    def solids(self) -> list[Thing]:
        w, d, t = self.width, self.depth, 0.05
        walls = [
            (-t, -t, w + t, t),
            (-t, d - t, w + t, d + t),
            (-t, -t, t, d + t),
            (w - t, -t, w + t, d + t),
            *self.walls,
        ]
        out = [Thing("floors", (-t, -t, -0.1, w + t, d + t, 0.0)), Thing("ceilings", (-t, -t, 2.4, w + t, d + t, 2.5))]
        out += [Thing("walls", (a, b, 0.0, c, e, 2.4)) for a, b, c, e in walls]
        return out + self.things


class ToyEnv:
    """Steps like ``UcON-v0``; a thing whose ``container`` is another thing's index shows only once that is open."""

    def __init__(
        self, home: ToyHome, target: str, start: tuple[int, int, int], *, nav: bool = True, size: int = 128
    ) -> None:
        self.home, self.target, self.start, self.nav, self.size = home, target, start, nav, size
        self.things = home.solids()
        self.offset = len(self.things) - len(home.things)
        self.free = self._free()
        assert self.free[start[:2]], "the toy start is not free"

    def _free(self) -> np.ndarray:
        nx, ny = round(self.home.width / CELL), round(self.home.depth / CELL)
        x = (np.arange(nx) + 0.5)[:, None] * CELL
        y = (np.arange(ny) + 0.5)[None] * CELL
        free = np.ones((nx, ny), bool)
        for thing in self.things:
            x0, y0, z0, x1, y1, z1 = thing.box
            if z1 > 0.05 and z0 < 1.8:
                gap = np.hypot(np.maximum(np.maximum(x0 - x, x - x1), 0), np.maximum(np.maximum(y0 - y, y - y1), 0))
                free &= gap >= 0.18
        return free

    def reset(self) -> tuple[dict, dict]:
        self.i, self.j, self.h = self.start
        self.pitch, self.steps, self.collision = 0, 0, 0
        self.opened: set[int] = set()
        self.tracks: dict[int, int] = {}
        self.moves = 0
        obs, info = self._look(())
        info |= {"episode": "toy", "scene": "toy", "habits": ()}
        if self.nav:
            info["nav"] = self._nav()
        return obs, info

    def _nav(self) -> dict:
        turned = np.rot90(self.free, -self.start[2])
        marks = np.zeros_like(self.free)
        marks[self.start[:2]] = True
        cell = np.argwhere(np.rot90(marks, -self.start[2]))[0]
        return {"free": np.ascontiguousarray(turned), "start": (int(cell[0]), int(cell[1]))}

    def step(self, action: int) -> tuple[dict, float, bool, bool, dict]:
        self.collision, opened, done, success = 0, (), False, False
        if action == 0:
            i, j = self.i + (1, 0, -1, 0)[self.h], self.j + (0, 1, 0, -1)[self.h]
            if 0 <= i < self.free.shape[0] and 0 <= j < self.free.shape[1] and self.free[i, j]:
                self.i, self.j, self.moves = i, j, self.moves + 1
            else:
                self.collision = 1
        elif action in (1, 2):
            self.h = (self.h + (3 if action == 1 else 1)) % 4
        elif action in (3, 4):
            self.pitch = min(max(self.pitch + (30 if action == 3 else -30), -60), 60)
        elif action == 5:
            opened = self._open()
        elif action == 6:
            done, success = True, self.in_reach()
        self.steps += 1
        obs, info = self._look(opened)
        info["success"] = success
        return obs, 0.0, done, self.steps >= 300, info

    @property
    def xy(self) -> tuple[float, float]:
        return (self.i + 0.5) * CELL, (self.j + 0.5) * CELL

    def gap(self, k: int) -> float:
        x, y = self.xy
        x0, y0, _, x1, y1, _ = self.things[k].box
        return float(np.hypot(max(x0 - x, x - x1, 0), max(y0 - y, y - y1, 0)))

    def in_reach(self) -> bool:
        counts = np.bincount(self._instance.ravel() + 1, minlength=len(self.things) + 1)[1:]
        return any(
            counts[k] >= 4 and self.gap(k) <= 1.0 for k, t in enumerate(self.things) if t.category == self.target
        )

    def _open(self) -> tuple[int, ...]:
        holders = {t.container + self.offset for t in self.home.things if t.container >= 0}
        seen = set(np.unique(self._instance).tolist())
        fresh = [k for k in holders - self.opened if k in seen and self.gap(k) <= 1.0]
        self.opened |= set(fresh)
        return tuple(self.tracks[k] for k in fresh)

    def _look(self, opened: tuple[int, ...]) -> tuple[dict, dict]:
        depth, self._instance = self._cast()
        counts = np.bincount(self._instance.ravel() + 1, minlength=len(self.things) + 1)[1:]
        seen = np.flatnonzero(counts >= 4)
        for k in seen:
            self.tracks.setdefault(int(k), len(self.tracks))
        table = np.full(len(self.things) + 1, -1, np.int16)
        for k, track in self.tracks.items():
            table[k] = track
        dx, dy = (self.i - self.start[0]) * CELL, (self.j - self.start[1]) * CELL
        c, s = (1, 0, -1, 0)[self.start[2]], (0, 1, 0, -1)[self.start[2]]
        yaw = (0, np.pi / 2, np.pi, -np.pi / 2)[(self.h - self.start[2]) % 4]
        pose = np.array([c * dx + s * dy, c * dy - s * dx, yaw, np.deg2rad(self.pitch)], np.float32)
        obs = {
            "depth": depth,
            "pose": pose,
            "collision": np.array([self.collision], np.int8),
            "step": np.array([self.steps]),
        }
        detections = {"track": table[seen], "category": [self.things[k].category for k in seen], "pixels": counts[seen]}
        info = {"detections": detections, "tracks": table[self._instance], "target": self.target, "opened": opened}
        return obs, info

    def _cast(self) -> tuple[np.ndarray, np.ndarray]:
        n = self.size
        t = (np.arange(n) + 0.5 - n / 2) / (n / 2)
        cp, sp = np.cos(np.deg2rad(self.pitch)), np.sin(np.deg2rad(self.pitch))
        c, s = (1, 0, -1, 0)[self.h], (0, 1, 0, -1)[self.h]
        up, right = -t[:, None], t[None]
        ahead = cp - sp * up + 0 * right
        ray = np.stack([c * ahead + s * right, s * ahead - c * right, sp + cp * up + 0 * right], -1)
        eye = np.array([*self.xy, 1.25])
        depth = np.full((n, n), np.inf)
        instance = np.full((n, n), -1)
        with np.errstate(divide="ignore", invalid="ignore"):
            for k, thing in enumerate(self.things):
                if thing.container >= 0 and thing.container + self.offset not in self.opened:
                    continue
                lo, hi = (np.array(thing.box[:3]) - eye) / ray, (np.array(thing.box[3:]) - eye) / ray
                near, far = np.fmin(lo, hi).max(-1), np.fmax(lo, hi).min(-1)
                if k in self.opened:  # an open box shows its back
                    near = far - 0.02
                hit = (near < far) & (near > 0.01) & (near < depth)
                depth[hit], instance[hit] = near[hit], k
        return depth.astype(np.float32), instance


def two_rooms() -> ToyHome:
    """A living room with a sofa and a table, a door, a kitchen with a cupboard that holds a cup."""
    things = [
        Thing("sofa", (0.2, 2.0, 0.0, 1.1, 4.0, 0.8)),
        Thing("coffee_table", (2.0, 2.5, 0.0, 2.6, 3.5, 0.45)),
        Thing("bottom_cabinet", (7.0, 4.4, 0.0, 7.8, 4.95, 0.9)),
        Thing("breakfast_table", (8.2, 1.5, 0.7, 9.4, 2.5, 0.75)),
        Thing("bowl", (2.2, 2.9, 0.45, 2.35, 3.05, 0.53)),
        Thing("pencil_box", (9.0, 2.1, 0.75, 9.2, 2.2, 0.8)),
        Thing("coffee_cup", (7.3, 4.6, 0.3, 7.4, 4.7, 0.42), container=2),
        Thing("teapot", (8.7, 1.9, 0.0, 8.9, 2.1, 0.2)),
    ]
    return ToyHome(10.0, 5.0, things, walls=[(5.45, 0.0, 5.55, 1.5), (5.45, 2.5, 5.55, 5.0)])
