"""One room while it is being furnished: its items, what must stay clear, and which nodes are walkable.

A :class:`Group` is a rigid arrangement of items in its own frame (origin at the back, +x into the room). The canvas
tries poses of a group in order of cost. It accepts the first that hits nothing, keeps every node reachable and leaves
every front accessible. Everything is vectorised over poses; nothing here depends on the type of the room.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ucon.objects.model import Box3, Vec3
from ucon.scenes.furnishing.grid import FLAT_M, allowed, flood, turned
from ucon.scenes.spec import GRID_M, WALL_THICKNESS_M, Item

Boxes = NDArray[np.float64]
"""(n, 6) as x0 y0 z0 x1 y1 z1."""
Score = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Poses (n, 3) as x, y, quarter turns to costs (n,)."""

CLEARANCE_M = 0.18
BODY_Z_M = (0.05, 1.8)
STEP_M = 0.125
SWEEP_Z_M = 0.3
MAX_TRIES = 14
MIN_NODES = 5


@dataclass
class Piece:
    """One item of a group.

    Attributes:
        category: of the catalogue.
        size: metres.
        x: centre of the footprint in the group's frame, metres.
        y: of the same.
        z: bottom.
        turns: quarter turns counter-clockwise.
        tint: colour variant.
    """

    category: str
    size: Vec3
    x: float
    y: float
    z: float = 0.0
    turns: int = 0
    tint: int = 0


@dataclass
class Group:
    """Pieces that belong together, spaces that must stay clear, and fronts that must be reachable."""

    pieces: list[Piece]
    voids: list[Box3] = field(default_factory=list)
    """Boxes that must stay clear of solid things, including those placed later."""
    fronts: list[tuple[float, float, float, float]] = field(default_factory=list)
    """Rectangles that must each contain a reachable node."""
    margin_m: float = 0.05
    """Least distance to walls at the sides, and at the back if it stands free."""

    def boxes(self) -> Boxes:
        """(n, 6) boxes of the pieces in the group's frame, metres."""
        return np.array([piece_box(p) for p in self.pieces]).reshape(-1, 6)


def piece_box(piece: Piece) -> Box3:
    """Box of a piece in the group's frame, metres."""
    sx, sy, sz = piece.size
    if piece.turns % 2:
        sx, sy = sy, sx
    return (piece.x - sx / 2, piece.y - sy / 2, piece.z, piece.x + sx / 2, piece.y + sy / 2, piece.z + sz)


class Canvas:
    """A room to furnish.

    Attributes:
        inner: its free floor x0, y0, x1, y1, metres.
        items: items placed so far.
        solids: (n, 6) their boxes.
        voids: (m, 6) spaces that must stay clear.
        fronts: rectangles that must each contain a reachable node.
        nodes_x: (nx,) x of the nodes, metres.
        nodes_y: (ny,) y of them.
        free: (nx, ny) bool, walkable nodes.
        door_nodes: nodes in the openings.
    """

    def __init__(
        self,
        room: int,
        rect: tuple[float, float, float, float],
        wall_height_m: float,
    ) -> None:
        """Start with an empty room.

        Args:
            room: its number.
            rect: x0, y0, x1, y1 on the grid, metres.
            wall_height_m: height of the walls.
        """
        self.room = room
        self.rect = rect
        self.wall_height_m = wall_height_m
        half = WALL_THICKNESS_M / 2
        self.inner = (rect[0] + half, rect[1] + half, rect[2] - half, rect[3] - half)
        self.items: list[Item] = []
        self.solids: Boxes = np.zeros((0, 6))
        self.voids: Boxes = np.zeros((0, 6))
        self.sweeps: Boxes = np.zeros((0, 6))
        """(m, 6) spaces above tables that cabinet doors sweep."""
        self.fronts: list[tuple[float, float, float, float]] = []
        self.doors: list[tuple[int, float, float]] = []
        """(wall, lo, hi) of every opening, along the wall."""
        shape = round((rect[2] - rect[0]) / GRID_M), round((rect[3] - rect[1]) / GRID_M)
        self.nodes_x = rect[0] + (np.arange(shape[0]) + 0.5) * GRID_M
        self.nodes_y = rect[1] + (np.arange(shape[1]) + 0.5) * GRID_M
        self.free = np.zeros(shape, bool)
        self.free[1:-1, 1:-1] = True
        self.door_nodes: list[tuple[int, int]] = []

    # -- openings ---------------------------------------------------------------------------------------------

    def add_opening(self, axis: int, coord: float, lo: float, hi: float, height_m: float, depth_m: float = 0.6) -> None:
        """Keep an opening in a wall of the room clear and walkable.

        Args:
            axis: 0 for a wall in a plane x = ``coord``, 1 for y.
            coord: of the plane, metres.
            lo: start of the opening along the wall.
            hi: its end.
            height_m: of the opening.
            depth_m: of the clear space in front of it.
        """
        wall = (axis if coord == self.rect[axis] else axis + 2) % 4
        self.doors.append((wall, lo, hi))
        side = 0.06
        void = [0.0] * 6
        inside = 1 if wall < 2 else -1
        span = sorted((coord, coord + inside * (depth_m + WALL_THICKNESS_M / 2)))
        void[axis], void[3 + axis] = span
        void[1 - axis], void[4 - axis] = lo - side, hi + side
        void[2], void[5] = FLAT_M, height_m
        self.voids = np.vstack([self.voids, void])
        across = self.nodes_y if axis == 0 else self.nodes_x
        ring = 0 if wall < 2 else -1
        for k in np.flatnonzero((across > lo + 0.3) & (across < hi - 0.3)):
            node = (ring % self.free.shape[0], int(k)) if axis == 0 else (int(k), ring % self.free.shape[1])
            self.free[node] = True
            self.door_nodes.append(node)

    # -- poses ------------------------------------------------------------------------------------------------

    def wall_length(self, wall: int) -> float:
        """Free length of a wall in metres: 0 west, 1 south, 2 east, 3 north."""
        return self.inner[3] - self.inner[1] if wall % 2 == 0 else self.inner[2] - self.inner[0]

    def wall_poses(self, group: Group, walls: Sequence[int], gap_m: float) -> NDArray[np.float64]:
        """Poses of a group along walls; at wall w it faces into the room with w quarter turns.

        Args:
            group: the group.
            walls: their numbers.
            gap_m: distance from the wall.

        Returns:
            (n, 3) x, y in metres, quarter turns.
        """
        boxes = group.boxes()
        low, high = boxes[:, 1].min(), boxes[:, 4].max()
        rows = []
        for wall in walls:
            turned_low, turned_high = (low, high) if wall in (0, 3) else (-high, -low)
            start, end = (self.inner[1], self.inner[3]) if wall % 2 == 0 else (self.inner[0], self.inner[2])
            first, last = start + group.margin_m - turned_low, end - group.margin_m - turned_high
            if last < first - 1e-9:
                continue
            at = np.unique(np.round(np.append(np.arange(first, last, STEP_M), last), 4))
            pose = np.empty((len(at), 3))
            if wall % 2 == 0:
                pose[:, 0] = self.inner[0] + gap_m if wall == 0 else self.inner[2] - gap_m
                pose[:, 1] = at
            else:
                pose[:, 0] = at
                pose[:, 1] = self.inner[1] + gap_m if wall == 1 else self.inner[3] - gap_m
            pose[:, 2] = wall
            rows.append(pose)
        return np.vstack(rows) if rows else np.zeros((0, 3))

    def free_poses(self, turns: Sequence[int], step_m: float = 0.25) -> NDArray[np.float64]:
        """Poses on a lattice over the whole floor.

        Args:
            turns: quarter turns to try.
            step_m: of the lattice.

        Returns:
            (n, 3) x, y in metres, quarter turns.
        """
        xs = np.arange(self.inner[0] + 0.1, self.inner[2], step_m)
        ys = np.arange(self.inner[1] + 0.1, self.inner[3], step_m)
        grid = np.stack(np.meshgrid(xs, ys, turns, indexing="ij"), -1)
        return grid.reshape(-1, 3).astype(float)

    # -- placing ----------------------------------------------------------------------------------------------

    def try_place(
        self, group: Group, poses: NDArray[np.float64], cost: NDArray[np.float64], *, walkable: bool = True
    ) -> bool:
        """Place a group at the cheapest allowed pose.

        Args:
            group: the group.
            poses: (n, 3) x, y in metres, quarter turns.
            cost: (n,).
            walkable: False skips the check of nodes, for things on furniture.

        Returns:
            Whether there was an allowed pose.
        """
        if not len(poses):
            return False
        local, voids = group.boxes(), np.array(group.voids, float).reshape(-1, 6)
        good = allowed(poses, local, voids, self.solids, self.voids, np.array(self.inner), self.wall_height_m)
        order = np.flatnonzero(good)
        order = order[np.argsort(cost[order], kind="stable")]
        stands = walkable and bool((local[:, 2] < BODY_Z_M[1]).any())
        far = order[MAX_TRIES // 2 :: max(1, 2 * len(order) // MAX_TRIES)]
        for index in np.append(order[: MAX_TRIES // 2], far):
            x, y, turn = float(poses[index, 0]), float(poses[index, 1]), int(poses[index, 2])
            world = turned(local, x, y, turn)
            if not stands or self._walkable(group, world, poses[index]):
                self._commit(group, world, turned(voids, x, y, turn), poses[index])
                return True
        return False

    def _blocked(self, boxes: Boxes) -> NDArray[np.bool_]:
        """(nx, ny) nodes within 0.18 m of boxes at the height of the agent."""
        tall = boxes[(boxes[:, 2] < BODY_Z_M[1]) & (boxes[:, 5] > BODY_Z_M[0])]
        dx = np.maximum(np.maximum(tall[:, 0, None] - self.nodes_x, self.nodes_x - tall[:, 3, None]), 0.0)
        dy = np.maximum(np.maximum(tall[:, 1, None] - self.nodes_y, self.nodes_y - tall[:, 4, None]), 0.0)
        return ((dx[:, :, None] ** 2 + dy[:, None, :] ** 2) < CLEARANCE_M**2 + 1e-9).any(0)

    def _walkable(self, group: Group, boxes: Boxes, pose: NDArray[np.float64]) -> bool:
        free = self.free & ~self._blocked(boxes)
        fronts = self.fronts + self._fronts(group, pose)
        reached = self.reached(free)
        if reached is None or (free & ~reached).any() or int(reached.sum()) < MIN_NODES:
            return False
        return all(self._in_front(reached, front) for front in fronts)

    def reached(self, free: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
        """Nodes reachable from the openings.

        Args:
            free: (nx, ny) bool.

        Returns:
            (nx, ny) bool; None where an opening is cut off.
        """
        if not all(free[node] for node in self.door_nodes):
            return None
        seed = self.door_nodes[0] if self.door_nodes else tuple(np.argwhere(free)[0]) if free.any() else None
        if seed is None:
            return None
        reached = flood(free, int(seed[0]), int(seed[1]))
        return reached if all(reached[node] for node in self.door_nodes) else None

    def _in_front(self, reached: NDArray[np.bool_], front: tuple[float, float, float, float]) -> bool:
        i0, i1 = np.searchsorted(self.nodes_x, (front[0], front[2]))
        j0, j1 = np.searchsorted(self.nodes_y, (front[1], front[3]))
        return bool(reached[i0:i1, j0:j1].any())

    def _fronts(self, group: Group, pose: NDArray[np.float64]) -> list[tuple[float, float, float, float]]:
        rows = np.array([(f[0], f[1], 0.0, f[2], f[3], 1.0) for f in group.fronts]).reshape(-1, 6)
        world = turned(rows, float(pose[0]), float(pose[1]), int(pose[2]))
        return [(float(b[0]), float(b[1]), float(b[3]), float(b[4])) for b in world]

    def _commit(self, group: Group, boxes: Boxes, voids: Boxes, pose: NDArray[np.float64]) -> None:
        turn = int(pose[2])
        for piece, box in zip(group.pieces, boxes, strict=True):
            x, y = (float(np.round((box[k] + box[3 + k]) / 2, 4)) for k in (0, 1))
            self.items.append(
                Item(
                    piece.category,
                    (round(piece.size[0], 4), round(piece.size[1], 4), round(piece.size[2], 4)),
                    (x, y, round(piece.z, 4)),
                    (turn + piece.turns) % 4,
                    self.room,
                    piece.tint,
                )
            )
        self.solids = np.vstack([self.solids, boxes])
        self.voids = np.vstack([self.voids, voids])
        self.sweeps = np.vstack([self.sweeps, voids[voids[:, 2] > SWEEP_Z_M]])
        self.fronts += self._fronts(group, pose)
        self.free &= ~self._blocked(boxes)
