"""Places where a target might be: sample points on top of, inside, under and next to everything seen.

Each (track, relation) is a handful of points that share its mass; a frame that shows a point from near enough
lowers that point's ``unseen``. What a category offers (surface, interior, space below) is the catalogue's knowledge.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.objects.models import build_model
from ucon.perception.mapping.map_kernels import look
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, camera_of
from ucon.perception.places.hollows import ALL_OPEN, fit, template
from ucon.perception.places.place_kernels import (
    INSIDE,
    MOST,
    NEXTTO,
    ONTOP,
    UNDER,
    facing,
    grown,
    inherit,
    make_points,
    searched,
)

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
    return Affordance(surface, bool(model.compartments), bool(model.under), row.openable, drawers, furniture, kind)


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


class Places(PartlyShared):
    """The sample points of all tracks of one map.

    Attributes:
        xyz: (n, 3) metres. track, relation: (n,) int32. share: (n,) parts of the mass of (track, relation), summing
        to 1 over its points, 0 for points that were replaced. unseen: (n,) in [0, 1], 1 = no frame showed it.
        hollow: (n, 6) box of the compartment that a point is in. faces: (n,) uint8, bits of its sides that can be
        looked through (-x, +x, -y, +y, -z, +z), all of them for points in no compartment.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"_rows", "_turn"})

    def __init__(self, target_height_m: float) -> None:
        self._lift_m = 0.5 * target_height_m
        self._made: NDArray[np.float64] = np.zeros((0, 6))
        self._seen_from: NDArray[np.float64] = np.zeros((0, 2))
        self._rows: dict[int, slice] = {}
        self._data = np.zeros((1024, 12))
        self._faces = np.zeros(1024, np.uint8)
        self._track = np.zeros(1024, np.int32)
        self._relation = np.zeros(1024, np.int32)
        self._n = 0
        self._scratch = np.zeros((MOST, 5))
        self._turning: NDArray[np.int64] = np.zeros(0, np.int64)
        self._sizes: NDArray[np.float64] = np.zeros((0, 3))
        self._quarters: NDArray[np.int32] = np.zeros(0, np.int32)
        self._turn: dict[int, int] = {}

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
        return self._relation[: self._n]

    @property
    def share(self) -> NDArray[np.float64]:
        """(n,) parts of the mass of (track, relation)."""
        return self._data[: self._n, 4]

    @property
    def unseen(self) -> NDArray[np.float64]:
        """(n,) in [0, 1], writable."""
        return self._data[: self._n, 5]

    @property
    def hollow(self) -> NDArray[np.float64]:
        """(n, 6) metres."""
        return self._data[: self._n, 6:]

    @property
    def faces(self) -> NDArray[np.uint8]:
        """(n,) bits of open sides."""
        return self._faces[: self._n]

    def refresh(self, known: SemanticMap) -> None:
        """Make points for new tracks, for those whose box grew, and for those that turn out to stand otherwise."""
        n = known.n_tracks
        if n > len(self._made):
            fresh = n - len(self._made)
            self._made = np.vstack([self._made, np.full((fresh, 6), np.inf)])
            self._seen_from = np.vstack([self._seen_from, np.zeros((fresh, 2))])
        moved = np.empty(n, np.int32)
        count = grown(known.box[:n], self._made, known.kind[:n], known.opened[:n], GROWTH_M, moved)
        anew = [track for track in moved[:count].tolist() if known.category[track]]
        if anew:
            self._seen_from[anew] = known.view.xy
        for track in sorted({*anew, *self._turned(known, anew)}):
            self._make(track, known)

    def _turned(self, known: SemanticMap, anew: list[int]) -> list[int]:
        """Tracks whose front seems to be elsewhere than it did; takes in those among ``anew`` that it does not know."""
        new = [track for track in anew if track not in self._turn and template(known.category[track]).turns]
        if new:
            self._turning = np.append(self._turning, new)
            self._sizes = np.array([template(known.category[k]).size for k in self._turning.tolist()])
            self._quarters = np.append(self._quarters, np.full(len(new), -1, np.int32))
        before, boxes = self._quarters.copy(), known.box[self._turning]
        if not facing(boxes, self._sizes, known.floor, known.blocked, known.walls, HALF, self._quarters):
            return []
        rows = np.flatnonzero(self._quarters != before)
        changed: list[int] = self._turning[rows].tolist()
        self._turn.update(zip(changed, self._quarters[rows].tolist(), strict=True))
        return changed

    def _make(self, track: int, known: SemanticMap) -> None:
        name, box = known.category[track], known.box[track]
        has, shape = affordance(name), template(name)
        whole = _whole(box, name, self._seen_from[track])
        count = make_points(whole, has.under, known.height, HALF, self._scratch)
        total = count + len(shape.share)
        self._reserve(total)
        rows = slice(self._n, self._n + total)
        self._n += total
        new, faces = self._data[rows], self._faces[rows]
        new[:count, :5], new[:, 5], faces[:] = self._scratch[:count], 1.0, ALL_OPEN
        fit(shape, whole, self._turn.get(track, 0), self._lift_m, new[count:], faces[count:])
        self._track[rows], self._relation[rows] = track, new[:, 3]
        if (old := self._rows.get(track)) is not None:
            inherit(new[:, :4], self._data[old, :4], self._data[old, 5], new[:, 5])
            self._data[old, 4:6] = 0.0
        self._rows[track] = rows
        self._made[track] = box

    def _reserve(self, count: int) -> None:
        if self._n + count > len(self._data):
            self._data = np.vstack([self._data, np.zeros_like(self._data)])
            self._faces = np.concatenate([self._faces, np.zeros_like(self._faces)])
            self._track = np.concatenate([self._track, np.zeros_like(self._track)])
            self._relation = np.concatenate([self._relation, np.zeros_like(self._relation)])

    def look(
        self, known: SemanticMap, depth: NDArray[np.float32], active: NDArray[np.bool_], reach_m: float, miss: float
    ) -> int:
        """Multiply ``unseen`` of the active points that the newest frame shows from within ``reach_m`` by ``miss``.

        ``depth`` is the frame's (H, W) or (H, W, 1) in metres. Returns how many points it shows.
        """
        flat = depth.reshape(depth.shape[:2])
        camera = camera_of(known.view, flat, known.body)
        return int(look(flat, camera, reach_m, self.xyz, self.hollow, self.faces, active, self.unseen, miss))

    def searched(self, shut: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(n,) points that may show something new, given which tracks are shut (T,)."""
        out = np.empty(self._n, bool)
        searched(self.track, self.relation, self.share, self.unseen, shut, out)
        return out

    def weights(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Weight of every point for the mass (T, 4) of tracks and relations; (n,)."""
        return mass[self.track, self.relation] * self.share * self.unseen

    def left(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T, 4) what is left of the mass (T, 4) of tracks and relations: what was not looked at in vain."""
        summed = np.bincount(4 * self.track + self.relation, self.weights(mass), mass.size)
        return np.asarray(summed, np.float64).reshape(mass.shape)

    def unseen_share(self, n_tracks: int) -> NDArray[np.float64]:
        """(T,) share of the places of every track that no frame has shown yet; its relations count alike."""
        row, shape = 4 * self.track + self.relation, (n_tracks, 4)
        left, total = (
            np.bincount(row, weight, 4 * n_tracks).reshape(shape).sum(1)
            for weight in (self.share * self.unseen, self.share)
        )
        return np.asarray(left / np.maximum(total, 1e-9))


def _whole(box: NDArray[np.float64], name: str, xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """The box of a thing with an inside, of which perhaps only one side was seen: as large as its kind usually is.

    What was not seen lies on the far side of the agent, which stood at ``xy`` when the box grew. Furniture comes in
    many widths, but is as deep as its kind; movable things are all of one size.
    """
    has, shape = affordance(name), template(name)
    if not shape.has(INSIDE):
        return box
    out = box.copy()
    sides = box[3:5] - box[:2]
    usual = np.sort(shape.size[:2])
    flat = int(sides[1] < sides[0])
    wanted = [(flat, usual[0])] if has.furniture else [(flat, usual[0]), (1 - flat, usual[1])]
    for axis, length in wanted:
        missing = float(length - sides[axis])
        if missing < (GROWTH_M if has.furniture else 0.02):
            continue
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
