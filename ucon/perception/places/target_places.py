"""Places where the target may be: sample points on top of, inside, under and next to everything seen.

Each (track, relation) has a few points that share its mass. A frame that shows a point from near enough lowers the
point's ``unseen``.
"""

from __future__ import annotations

from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.map_kernels import look
from ucon.perception.mapping.semantic_map import HALF, SemanticMap, camera_of
from ucon.perception.places.affordances import affordance
from ucon.perception.places.chance_kernels import look_by_chance
from ucon.perception.places.hollows import ALL_OPEN, fit, template
from ucon.perception.places.place_kernels import (
    INSIDE,
    MOST,
    changed_boxes,
    copy_unseen,
    facing,
    make_points,
    searched,
)
from ucon.perception.places.sight import Sight
from ucon.perception.views.view_kernels import WORDS

#: Share of a noted point by the shape of its thing: practically none, but above 0, which marks replaced points.
NOTED: Final = 1e-12
#: A track's points are made again when a side of its box moved by more than this, metres.
GROWTH_M = 0.15


class Places(PartlyShared):
    """The n sample points of all tracks of one map, and what was seen of each.

    Points of a track are replaced when its box grows; replaced points stay, with a share of 0. Every column is an array
    of its own, contiguous at any length: kernels are compiled for one layout.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"_rows", "_turn"})

    def __init__(self, target_height_m: float, sight: Sight | None = None) -> None:
        """Start without points.

        Args:
            target_height_m: height of the target in metres; points lie half of it above the surface.
            sight: what a look is worth, where the detector errs.
        """
        self.sight, self.target_height_m = sight, target_height_m
        self._looked = np.zeros(1024, np.uint64)
        self._hidden = np.zeros((1024, WORDS), np.uint64)
        self._lift_m = 0.5 * target_height_m
        self._made: NDArray[np.float64] = np.zeros((0, 6))
        self._seen_from: NDArray[np.float64] = np.zeros((0, 2))
        self._rows: dict[int, slice] = {}
        self._xyz, self._hollow = np.zeros((1024, 3)), np.zeros((1024, 6))
        self._even, self._share, self._unseen = np.zeros(1024), np.zeros(1024), np.zeros(1024)
        self._faces = np.zeros(1024, np.uint8)
        self._track = np.zeros(1024, np.int32)
        self._relation = np.zeros(1024, np.int32)
        self._n = 0
        self._scratch = np.zeros((MOST, 5))
        self._turning: NDArray[np.int64] = np.zeros(0, np.int64)
        self._sizes: NDArray[np.float64] = np.zeros((0, 3))
        self._quarters: NDArray[np.int32] = np.zeros(0, np.int32)
        self._turn: dict[int, int] = {}
        self._named = -1

    @property
    def xyz(self) -> NDArray[np.float64]:
        """(n, 3) float64, metres in the start frame."""
        return self._xyz[: self._n]

    @property
    def track(self) -> NDArray[np.int32]:
        """(n,) int32, the track that each point belongs to."""
        return self._track[: self._n]

    @property
    def relation(self) -> NDArray[np.int32]:
        """(n,) int32, ONTOP, INSIDE, UNDER or NEXTTO."""
        return self._relation[: self._n]

    @property
    def share(self) -> NDArray[np.float64]:
        """(n,) float64, share of the mass of the point's (track, relation).

        Sums to 1 over the points of a (track, relation); 0 for replaced points.
        """
        return self._share[: self._n]

    @property
    def even(self) -> NDArray[np.float64]:
        """(n,) float64, share by the shape of the thing alone; equals ``share`` unless :meth:`divide` changed that."""
        return self._even[: self._n]

    def divide(self, mass: NDArray[np.float64]) -> None:
        """Set ``share`` so that each (track, relation) divides its mass among its points as given.

        Points that are made later start with their ``even`` share.

        Args:
            mass: (n,) of every point; the points of a (track, relation) without any mass keep their ``even`` shares.
        """
        row = 4 * self.track + self.relation
        total = np.bincount(row, mass)[row]
        held = total > 0.0
        self.share[:] = np.where(held, mass / np.where(held, total, 1.0), self.even)

    @property
    def unseen(self) -> NDArray[np.float64]:
        """(n,) float64 in [0, 1], writable: probability that a target at the point would not have been seen so far."""
        return self._unseen[: self._n]

    @property
    def looked(self) -> NDArray[np.uint64]:
        """(n,) uint64, writable: bits of the sides and distances from which each point was looked at."""
        return self._looked[: self._n]

    @property
    def hidden(self) -> NDArray[np.uint64]:
        """(n, WORDS) uint64, writable: bits of the nodes around each point from which known things hide it."""
        return self._hidden[: self._n]

    @property
    def hollow(self) -> NDArray[np.float64]:
        """(n, 6) float64, box of the point's compartment: x0 y0 z0 x1 y1 z1 in metres."""
        return self._hollow[: self._n]

    @property
    def faces(self) -> NDArray[np.uint8]:
        """(n,) uint8, bits of the compartment's open sides (-x, +x, -y, +y, -z, +z).

        All six for points in no compartment.
        """
        return self._faces[: self._n]

    def refresh(self, known: SemanticMap) -> None:
        """Make points for new tracks, for tracks whose box changed, and for things that turn out to face another way.

        Call it after each update of the map. New points keep what was seen of the old ones near them.
        """
        n = known.n_tracks
        if n > len(self._made):
            fresh = n - len(self._made)
            self._made = np.vstack([self._made, np.full((fresh, 6), np.inf)])
            self._seen_from = np.vstack([self._seen_from, np.zeros((fresh, 2))])
        moved = np.empty(n, np.int32)
        count = changed_boxes(known.box[:n], self._made, known.kind[:n], known.opened[:n], GROWTH_M, moved)
        changed = [track for track in moved[:count].tolist() if known.category[track]]
        if changed:
            self._seen_from[changed] = known.view.xy
        renamed = self._renamed(known)
        changed += [track for track in renamed if known.category[track] and track not in changed]
        for track in sorted({*changed, *self._turned(known, changed)}):
            self._make(track, known)

    def _renamed(self, known: SemanticMap) -> list[int]:
        """Tracks with points whose name changed since the last call.

        Their orientation is forgotten, and so are the points of tracks that are no thing after all.
        """
        rows = [k for k in np.flatnonzero(known.named_at[: known.n_tracks] > self._named).tolist() if k in self._rows]
        self._named = known.step
        for track in rows:
            self._turn.pop(track, None)
            if not known.category[track]:
                old = self._rows.pop(track)
                self._even[old] = self._share[old] = self._unseen[old] = 0.0
                self._made[track] = np.inf
        if rows and (stale := np.isin(self._turning, rows)).any():
            self._turning, self._quarters = self._turning[~stale], self._quarters[~stale]
            self._sizes = self._sizes[~stale]
        return rows

    def _turned(self, known: SemanticMap, tracks: list[int]) -> list[int]:
        """Tracks whose estimated orientation changed. Those of ``tracks`` without an estimate get their first one."""
        new = [track for track in tracks if track not in self._turn and template(known.category[track]).turns]
        if new:
            self._turning = np.append(self._turning, new)
            self._sizes = np.array([template(known.category[k]).size for k in self._turning.tolist()])
            self._quarters = np.append(self._quarters, np.full(len(new), -1, np.int32))
        if not len(self._turning):
            return []
        before, boxes = self._quarters.copy(), known.box[self._turning]
        if not facing(boxes, self._sizes, known.floor, known.blocked, known.walls, HALF, self._quarters):
            return []
        rows = np.flatnonzero(self._quarters != before)
        changed: list[int] = self._turning[rows].tolist()
        self._turn.update(zip(changed, self._quarters[rows].tolist(), strict=True))
        return changed

    def _make(self, track: int, known: SemanticMap) -> None:
        """Make the points of a track; its old ones are replaced."""
        name, box = known.category[track], known.box[track]
        has, shape = affordance(name), template(name)
        whole = _whole(box, name, self._seen_from[track])
        count = make_points(whole, has.under, known.height, HALF, self._scratch)
        total = count + len(shape.share)
        self._reserve(total)
        rows = slice(self._n, self._n + total)
        self._n += total
        new, faces = np.zeros((total, 12)), self._faces[rows]
        new[:count, :5], faces[:] = self._scratch[:count], ALL_OPEN
        fit(shape, whole, self._turn.get(track, 0), self._lift_m, new[count:], faces[count:])
        self._xyz[rows], self._relation[rows] = new[:, :3], new[:, 3]
        self._even[rows] = self._share[rows] = new[:, 4]
        self._track[rows], self._unseen[rows], self._hollow[rows] = track, 1.0, new[:, 6:]
        self._looked[rows] = 0
        if (old := self._rows.get(track)) is not None:
            copy_unseen(
                self._xyz[rows], self._relation[rows], self._xyz[old], self._relation[old],
                self._unseen[old], self._unseen[rows], self._looked[old], self._looked[rows],
            )  # fmt: skip
            self._even[old] = self._share[old] = self._unseen[old] = 0.0
        self._rows[track] = rows
        self._made[track] = box

    def note(self, xyz: NDArray[np.float64], like: int, row: int = -1) -> int:
        """Add a point apart from those of the thing's shape; it is never replaced, and has mass only by :meth:`divide`.

        Args:
            xyz: (3,) metres.
            like: row of a point of the same thing and relation. The new point is in the same compartment, if it lies in
                its box; otherwise nothing is known of what is open around it.
            row: of the point, where it was added before: it is moved to the thing and relation of ``like``.

        Returns:
            Its row.
        """
        if row < 0:
            self._reserve(1)
            row, self._n = self._n, self._n + 1
            self._xyz[row], self._unseen[row], self._looked[row] = xyz, 1.0, 0
            copy_unseen(
                self._xyz[row : row + 1], self._relation[like : like + 1], self._xyz[like : like + 1],
                self._relation[like : like + 1], self._unseen[like : like + 1], self._unseen[row : row + 1],
                self._looked[like : like + 1], self._looked[row : row + 1],
            )  # fmt: skip
        self._even[row], self._share[row], self._hidden[row] = NOTED, NOTED, 0
        for column in (self._hollow, self._faces, self._track, self._relation):
            column[row] = column[like]
        hollow = self._hollow[row]
        if not ((hollow[:3] <= xyz) & (xyz <= hollow[3:])).all():
            self._faces[row] = ALL_OPEN
        return row

    def drop(self, row: int) -> None:
        """Let a noted point count as replaced, until :meth:`note` is called for it again."""
        self._even[row] = self._share[row] = 0.0

    def _reserve(self, count: int) -> None:
        """Make room for ``count`` more points."""
        if self._n + count > len(self._xyz):
            for name in (
                "_xyz", "_hollow", "_even", "_share", "_unseen", "_looked", "_hidden", "_faces", "_track", "_relation",
            ):  # fmt: skip
                column = getattr(self, name)
                setattr(self, name, np.concatenate([column, np.zeros_like(column)]))

    def look(
        self, known: SemanticMap, depth: NDArray[np.float32], active: NDArray[np.bool_], reach_m: float, miss: float
    ) -> int:
        """Lower ``unseen`` of the points that the newest frame shows.

        Args:
            known: the map, updated with the frame.
            depth: (H, W) or (H, W, 1) float32, metres along the optical axis.
            active: (n,) bool, points to look at; see :meth:`searched`.
            reach_m: greatest optical depth from which a target would be recognised, metres.
            miss: probability that a frame that shows a point misses a target there; multiplies ``unseen``. Where the
                detector errs, ``sight`` gives this probability instead, unless ``miss`` is 1: then nothing is learned.

        Returns:
            How many points the frame shows.
        """
        flat = known.body.farthest(depth.reshape(depth.shape[:2]))
        camera = camera_of(known.view, flat, known.body)
        if self.sight is not None and miss < 1.0:
            return int(
                look_by_chance(
                    flat, camera, self.sight.model, self.xyz, self.hollow, self.faces, active, self.unseen, self.looked
                )
            )
        return int(look(flat, camera, reach_m, self.xyz, self.hollow, self.faces, active, self.unseen, miss))

    def searched(self, shut: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Points at which a frame may show something new; argument of :meth:`look`.

        Args:
            shut: (T,) bool, closed containers by track; points inside them are left out.

        Returns:
            (n,) bool.
        """
        out = np.empty(self._n, bool)
        searched(self.track, self.relation, self.even, self.unseen, shut, out)
        return out

    def weights(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mass of every point that remains after the looks so far.

        Args:
            mass: (T, 4) mass of tracks and relations.

        Returns:
            (n,) float64.
        """
        return mass[self.track, self.relation] * self.share * self.unseen

    def remaining_mass(self, mass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mass of tracks and relations that remains after the looks so far.

        Args:
            mass: (T, 4) mass before anything was looked at.

        Returns:
            (T, 4) float64.
        """
        summed = np.bincount(4 * self.track + self.relation, self.weights(mass), mass.size)
        return np.asarray(summed, np.float64).reshape(mass.shape)

    def unseen_share(self, n_tracks: int) -> NDArray[np.float64]:
        """Share of each track's places that no frame has shown yet; the relations it offers count equally.

        Returns:
            (T,) float64 in [0, 1].
        """
        row, shape = 4 * self.track + self.relation, (n_tracks, 4)
        left, total = (
            np.bincount(row, weight, 4 * n_tracks).reshape(shape).sum(1)
            for weight in (self.even * self.unseen, self.even)
        )
        return np.asarray(left / np.maximum(total, 1e-9))


def _whole(box: NDArray[np.float64], name: str, xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """The box (6,) of a container of which perhaps only one side was seen, extended to the usual size of its category.

    Only things with an inside are extended, away from the agent, which stood at ``xy`` when the box grew. Furniture
    comes in many widths, so only its depth is extended; movable things are extended both ways.
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
