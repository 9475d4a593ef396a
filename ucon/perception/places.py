"""Places where a target might be: sample points on top of, inside, under and next to everything seen.

Each (track, relation) is a handful of points that share its mass evenly; a frame that shows a point from near enough
lowers that point's ``unseen``. What a category offers (surface, interior, space below) is the catalogue's knowledge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ucon.objects.catalogue import catalogue
from ucon.objects.models import build_model
from ucon.perception.place_kernels import INSIDE, MOST, NEXTTO, ONTOP, UNDER, inherit, make_points
from ucon.perception.semantic_map import CAMERA_M, HALF, SemanticMap

__all__ = [
    "INSIDE",
    "NEXTTO",
    "ONTOP",
    "UNDER",
    "Affordance",
    "Kind",
    "Places",
    "affordance",
    "has_room",
    "sight_range_m",
    "with_fallback",
]

#: A track's points are made anew when a side of its box moved by this much.
GROWTH_M = 0.15


#: Sorts of things: by role, and what is fixed by where it is mounted.
Kind = Literal["fixed_furniture", "movable_furniture", "fixture", "wall", "ceiling", "movable", "structure"]
_FIXED: dict[str, Kind] = {"wall": "wall", "ceiling": "ceiling"}


#: Archetypes of furniture that is open, or opens, at its top.
_LIDDED = ("bin", "chest_lidded", "tank_box")
#: Nobody can come nearer to a thing's side than this.
_NEAREST_M = 0.4


@dataclass(frozen=True)
class Affordance:
    """What a category offers as a place, by the catalogue."""

    ontop: bool
    inside: bool
    under: bool
    openable: bool
    drawers: bool
    furniture: bool
    kind: Kind = "movable"
    from_above: bool = False
    """Whether its inside shows only to who looks down into it."""
    depth_m: float = 0.0
    """The shorter of its horizontal sides."""

    @cached_property
    def offers(self) -> NDArray[np.bool_]:
        """(3,) top, inside, space below."""
        return np.array([self.ontop, self.inside or self.openable, self.under])


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
    kind: Kind = _FIXED.get(row.mount, "fixture") if row.role == "fixed" else row.role
    above = bool(model.compartments) and (kind == "movable" or row.archetype in _LIDDED)
    return Affordance(
        surface, bool(model.compartments), bool(model.under), row.openable, drawers, furniture, kind, above,
        min(row.size[:2]),
    )  # fmt: skip


@lru_cache(maxsize=4096)
def sight_range_m(category: str, min_pixels: float = 5.0) -> float:
    """Optical depth up to which a thing of this category shows ``min_pixels`` in a 128 x 128 view of 90 degrees."""
    book = catalogue()
    x, y, z = sorted(book[category].size) if category in book else (0.1, 0.1, 0.1)
    area = (x * y + x * z + y * z) / 3
    return float(np.clip(64.0 * np.sqrt(area / min_pixels), 1.2, 4.5))


@lru_cache(maxsize=65536)
def has_room(target: str, category: str) -> tuple[bool, bool, bool]:
    """Whether a target's catalogue size goes on top of, into, and under a thing of a category."""
    book = catalogue()
    if target not in book or category not in book:
        return True, True, True
    small, middle, large = sorted(book[target].size)
    wide, deep, high = book[category].size
    ontop = small <= 1.1 * min(wide, deep) and middle <= 1.1 * max(wide, deep)
    inside = all(a <= b for a, b in zip((small, middle, large), sorted((wide, deep, high)), strict=True))
    return ontop, inside, small <= 0.7 * high


class Places:
    """The sample points of all tracks of one map.

    Attributes:
        xyz: (n, 3) metres. track, relation: (n,) int32. share: (n,) parts of the mass of (track, relation), summing
        to 1 over its points, 0 for points that were replaced. unseen: (n,) in [0, 1], 1 = no frame showed it.
        far_m: (n,) horizontal distance beyond which the thing's own rim hides the point.
    """

    def __init__(self, target_height_m: float) -> None:
        self._lift_m = 0.5 * target_height_m
        self._made: NDArray[np.float64] = np.zeros((0, 6))
        self._rows: dict[int, slice] = {}
        self._data = np.zeros((1024, 7))
        self._track = np.zeros(1024, np.int32)
        self._n = 0
        self._scratch = np.zeros((MOST, 5))

    @property
    def xyz(self) -> NDArray[np.float64]:
        """(n, 3) metres."""
        return self._data[: self._n, :3]

    @property
    def track(self) -> NDArray[np.int32]:
        """(n,) int32."""
        return self._track[: self._n]

    @property
    def relation(self) -> NDArray[np.int32]:
        """(n,) int32."""
        return self._data[: self._n, 3].astype(np.int32)

    @property
    def share(self) -> NDArray[np.float64]:
        """(n,) parts of the mass of (track, relation)."""
        return self._data[: self._n, 4]

    @property
    def unseen(self) -> NDArray[np.float64]:
        """(n,) in [0, 1], writable."""
        return self._data[: self._n, 5]

    @property
    def far_m(self) -> NDArray[np.float64]:
        """(n,) metres."""
        return self._data[: self._n, 6]

    def refresh(self, known: SemanticMap) -> None:
        """Make points for new tracks and for those whose box grew."""
        n = known.n_tracks
        if n > len(self._made):
            self._made = np.vstack([self._made, np.full((n - len(self._made), 6), np.inf)])
        moved = np.abs(known.box[:n] - self._made).max(1) > GROWTH_M
        moved &= (known.kind[:n] == 0) & (known.box[:n, 3] >= known.box[:n, 0]) & ~known.opened[:n]
        for track in np.flatnonzero(moved).tolist():
            if known.category[track]:
                self._make(track, known)

    def _make(self, track: int, known: SemanticMap) -> None:
        has = affordance(known.category[track])
        box = known.box[track]
        count = make_points(
            _whole(box, has, known.view.xy), has.offers, self._lift_m, known.height, HALF, self._scratch
        )
        if self._n + count > len(self._data):
            self._data = np.vstack([self._data, np.zeros_like(self._data)])
            self._track = np.concatenate([self._track, np.zeros_like(self._track)])
        rows = slice(self._n, self._n + count)
        self._n += count
        new = self._data[rows]
        new[:, :5], new[:, 5], new[:, 6] = self._scratch[:count], 1.0, np.inf
        if has.from_above:
            self._sink(new, box)
        self._track[rows] = track
        if (old := self._rows.get(track)) is not None:
            inherit(new[:, :4], self._data[old, :4], self._data[old, 5], new[:, 5])
            self._data[old, 4:] = 0.0
        self._rows[track] = rows
        self._made[track] = box

    def _sink(self, new: NDArray[np.float64], box: NDArray[np.float64]) -> None:
        """Lower the points in a thing that is open above to where the target's top would be, and say who sees it."""
        half_m, rim = 0.5 * float(min(box[3] - box[0], box[4] - box[1])), float(box[5])
        top = min(float(box[2]) + 0.04 + 2.0 * self._lift_m, rim)
        rows = new[:, 3] == INSIDE
        new[rows, 2] = top
        steep_m = half_m * (CAMERA_M - top) / max(rim - top, 0.02)
        new[rows, 6] = max(steep_m, half_m + _NEAREST_M)

    def weights(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weight of every point for the mass (T, 4) of tracks and relations; (n,)."""
        return mass[self.track, self.relation] * self.share * self.unseen

    def left(self, n_tracks: int) -> NDArray[np.float64]:
        """Share of every (track, relation) that was not looked at yet, (T, 4)."""
        out = np.zeros((n_tracks, 4))
        np.add.at(out, (self.track, self.relation), self.share * self.unseen)
        return out


def _whole(box: NDArray[np.float64], has: Affordance, xy: tuple[float, float]) -> NDArray[np.float64]:
    """The box of a thing with an inside, of which perhaps only the front was seen: as deep as its kind usually is.

    The part not seen lies on the far side of the agent, which stands at ``xy``.
    """
    if not has.openable or has.from_above:
        return box
    axis = int(box[4] - box[1] < box[3] - box[0])
    missing = has.depth_m - float(box[3 + axis] - box[axis])
    if missing < GROWTH_M:
        return box
    out = box.copy()
    if xy[axis] < 0.5 * float(box[axis] + box[3 + axis]):
        out[3 + axis] += missing
    else:
        out[axis] -= missing
    return out


def with_fallback(mass: NDArray[np.float64], category: str) -> NDArray[np.float64]:
    """Mass (4,) of one thing, what it cannot offer moved to next to it."""
    out = np.where(np.append(affordance(category).offers, True), mass, 0.0)
    out[NEXTTO] += mass.sum() - out.sum()
    return out
