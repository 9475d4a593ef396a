"""Places where a target might be: sample points on top of, inside, under and next to everything seen.

Each (track, relation) is a handful of points that share its mass evenly; a frame that shows a point from near enough
lowers that point's ``unseen``. What a category offers (surface, interior, space below) is the catalogue's knowledge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.objects.models import build_model
from ucon.perception.semantic_map import CELL_M, HALF, SemanticMap

ONTOP, INSIDE, UNDER, NEXTTO = range(4)
#: A track's points are made anew when a side of its box moved by this much.
GROWTH_M = 0.15
_SPACING_M = 0.5


@dataclass(frozen=True, slots=True)
class Affordance:
    """What a category offers as a place, by the catalogue."""

    ontop: bool
    inside: bool
    under: bool
    openable: bool
    drawers: bool
    furniture: bool


@lru_cache(maxsize=4096)
def affordance(category: str) -> Affordance:
    """What things of a category offer; a name outside the catalogue counts as a plain thing with a top."""
    book = catalogue()
    if category not in book:
        return Affordance(True, False, False, False, False, False)
    row, model = book[category], build_model(category)
    drawers = any(joint.kind == "prismatic" for joint in model.joints)
    furniture = row.role in ("fixed_furniture", "movable_furniture", "fixed")
    surface = bool(model.surfaces) and row.mount != "ceiling"
    return Affordance(surface, bool(model.compartments), bool(model.under), row.openable, drawers, furniture)


@lru_cache(maxsize=4096)
def sight_range_m(category: str, min_pixels: float = 5.0) -> float:
    """Optical depth up to which a thing of this category shows ``min_pixels`` in a 128 x 128 view of 90 degrees."""
    book = catalogue()
    x, y, z = sorted(book[category].size) if category in book else (0.1, 0.1, 0.1)
    area = (x * y + x * z + y * z) / 3
    return float(np.clip(64.0 * np.sqrt(area / min_pixels), 1.2, 4.5))


class Places:
    """The sample points of all tracks of one map.

    Attributes:
        xyz: (n, 3) metres. track, relation: (n,) int32. share: (n,) parts of the mass of (track, relation), summing
        to 1 over its points. unseen: (n,) in [0, 1], 1 = no frame showed it.
    """

    def __init__(self, target_height_m: float) -> None:
        self._lift_m = 0.5 * target_height_m
        self._made: NDArray[np.float64] = np.zeros((0, 6))
        self._rows: dict[int, NDArray[np.int64]] = {}
        self.xyz: NDArray[np.float64] = np.zeros((0, 3))
        self.track: NDArray[np.int32] = np.zeros(0, np.int32)
        self.relation: NDArray[np.int32] = np.zeros(0, np.int32)
        self.share: NDArray[np.float64] = np.zeros(0)
        self.unseen: NDArray[np.float64] = np.zeros(0)
        self.faded: NDArray[np.float64] = np.zeros(0)

    def refresh(self, known: SemanticMap) -> None:
        """Make points for new tracks and for those whose box grew."""
        n = known.n_tracks
        if n > len(self._made):
            self._made = np.vstack([self._made, np.full((n - len(self._made), 6), np.inf)])
        moved = np.abs(known.box[:n] - self._made).max(1) > GROWTH_M
        moved &= (known.kind[:n] == 0) & (known.box[:n, 3] >= known.box[:n, 0]) & ~known.opened[:n]
        for track in np.flatnonzero(moved):
            if known.category[track]:
                self._make(int(track), known)

    def _make(self, track: int, known: SemanticMap) -> None:
        box = known.box[track]
        xyz, relation, share = _points(box, self._lift_m, known.height)
        unseen = np.ones(len(xyz))
        old = self._rows.get(track)
        keep = np.ones(len(self.track), bool)
        if old is not None:
            for n in range(len(xyz)):
                same = old[self.relation[old] == relation[n]]
                if len(same):
                    gap = np.abs(self.xyz[same] - xyz[n]).max(1)
                    nearest = int(gap.argmin())
                    unseen[n] = self.unseen[same[nearest]] if gap[nearest] < 0.3 else 1.0
            keep[old] = False
        self.xyz = np.vstack([self.xyz[keep], xyz])
        self.track = np.concatenate([self.track[keep], np.full(len(xyz), track, np.int32)])
        self.relation = np.concatenate([self.relation[keep], relation])
        self.share = np.concatenate([self.share[keep], share])
        self.unseen = np.concatenate([self.unseen[keep], unseen])
        self._made[track] = box
        if old is None:
            self._rows[track] = np.arange(len(self.track) - len(xyz), len(self.track))
        else:
            order = np.argsort(self.track, kind="stable")
            cuts = np.searchsorted(self.track[order], np.unique(self.track))
            self._rows = {int(self.track[rows[0]]): rows for rows in np.split(order, cuts[1:])}

    def weights(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weight of every point for the mass (T, 4) of tracks and relations; (n,)."""
        return mass[self.track, self.relation] * self.share * self.unseen

    def left(self, n_tracks: int) -> NDArray[np.float64]:
        """Share of every (track, relation) that was not looked at yet, (T, 4)."""
        out = np.zeros((n_tracks, 4))
        np.add.at(out, (self.track, self.relation), self.share * self.unseen)
        return out


def _points(
    box: NDArray[np.float64], lift_m: float, height: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """Points (n, 3), relations (n,) and shares (n,) of one box."""
    x0, y0, z0, x1, y1, z1 = box
    groups = (
        _lattice(x0, x1, y0, y1, (z1 + lift_m,), 4),
        _lattice(x0, x1, y0, y1, _levels(z0, z1), 3),
        _lattice(x0, x1, y0, y1, (0.08,), 3),
        _around(box, height),
    )
    relation = np.concatenate([np.full(len(g), k, np.int32) for k, g in enumerate(groups)])
    share = np.concatenate([np.full(len(g), 1.0 / len(g)) for g in groups])
    return np.vstack(groups), relation, share


def _lattice(x0: float, x1: float, y0: float, y1: float, levels: tuple[float, ...], most: int) -> NDArray[np.float64]:
    def ticks(a: float, b: float) -> NDArray[np.float64]:
        n = int(np.clip(round((b - a) / _SPACING_M), 1, most))
        return a + (np.arange(n) + 0.5) * (b - a) / n

    return np.array([(x, y, z) for x in ticks(x0, x1) for y in ticks(y0, y1) for z in levels])


def _levels(z0: float, z1: float) -> tuple[float, ...]:
    n = int(np.clip(round((z1 - z0) / 0.45), 1, 4))
    return tuple(z0 + (k + 0.5) * (z1 - z0) / n for k in range(n))


def _around(box: NDArray[np.float64], height: NDArray[np.float32]) -> NDArray[np.float64]:
    """Points beside a box, on the floor or on what it stands on; without those that a wall or a tall thing takes."""
    x0, y0, z0, x1, y1, z1 = box
    if max(x1 - x0, y1 - y0) < 0.45:
        return np.array([[(x0 + x1) / 2, (y0 + y1) / 2, z1 + 0.02]])
    z = 0.1 if z0 < 0.4 else z0 + 0.08
    points = []
    for a, b, c, d in ((x0, x0, y0, y1), (x1, x1, y0, y1), (x0, x1, y0, y0), (x0, x1, y1, y1)):
        n = 2 if b - a + d - c > 1.2 else 1
        nx, ny = (-1.0 if a == x0 else 1.0, 0.0) if a == b else (0.0, -1.0 if c == y0 else 1.0)
        for k in range(n):
            t = (k + 0.5) / n
            points.append((a + t * (b - a) + 0.15 * nx, c + t * (d - c) + 0.15 * ny, z))
    out = np.array(points)
    cells = np.clip(np.floor(out[:, :2] / CELL_M + 0.5).astype(int) + HALF, 0, len(height) - 1)
    open_air = height[cells[:, 0], cells[:, 1]] < (9.0 if z1 > 1.4 else 1.5)
    return out[open_air] if open_air.any() else out
