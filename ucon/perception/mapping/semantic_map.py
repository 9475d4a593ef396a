"""The 0.25 m semantic map that an agent builds from its own frames: cells, tracked things, what was looked at.

The frame is the agent's: its first pose is the origin looking along +x. Cells are centred on the nodes where it can
stand. The map covers 64 m x 64 m, more than any home; what lies outside is ignored.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.mapping import map_kernels as kernels
from ucon.perception.mapping.body import PAPER_BODY, Body
from ucon.perception.mapping.detections import MIN_PIXELS, STRUCTURE_KINDS, Detections

CELL_M = kernels.CELL_M
HALF = 128
SIZE = 2 * HALF + 1
CARVE_M = 8.0
_FOV_DEG = 90.0
_PITCH = {p: (float(np.cos(np.deg2rad(p))), float(np.sin(np.deg2rad(p)))) for p in (-60, -30, 0, 30, 60)}


@dataclass(frozen=True, slots=True)
class View(Shared):
    """A pose of the agent: cell (i, j), heading in quarter turns counter-clockwise, pitch in degrees, up positive.

    More generally the look of :class:`~ucon.perception.mapping.body.Body`, where the rules know no pitch.
    """

    i: int
    j: int
    heading: int
    pitch_deg: int = 0

    @property
    def xy(self) -> tuple[float, float]:
        """Metres from the start."""
        return (self.i - HALF) * CELL_M, (self.j - HALF) * CELL_M


class SemanticMap(PartlyShared):
    """Everything one agent has seen in one episode. Arrays are (257, 257), indexed [i, j] = [x, y].

    Attributes:
        body: what the agent knows of its own camera and reach.
        explored: uint8, sight lines passed over the cell. height: float32, tallest thing seen in it below 1.9 m.
        near: float32, least optical depth at which anything in it was seen. floor: uint8, floor seen.
        walls: (2, 257, 257) uint8, a wall stands between (i, j) and (i + 1, j), or (i, j + 1).
        blocked: uint8, an obstacle was seen within the robot's radius of the node. bumped: uint8, a move failed.
        category: name of each track ("" until detected). box: (T, 6) float64 x0 y0 z0 x1 y1 z1 of the points seen.
        opened: (T,) bool. pixels: (T,) int32 pixels in the last frame.
        last_seen: (T,) int32 step, -1 never. views: poses so far.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"views", "category"})

    def __init__(self, body: Body = PAPER_BODY) -> None:
        self.body = body

        def grid(dtype: type, fill: float = 0) -> NDArray[Any]:
            return np.full((SIZE, SIZE), fill, dtype)

        self.explored, self.floor, self.blocked, self.bumped, self.visited = (grid(np.uint8) for _ in range(5))
        self.height = grid(np.float32, -1.0)
        self.near = grid(np.float32, 1e3)
        self.walls = np.zeros((2, SIZE, SIZE), np.uint8)
        self.step = 0
        self.fresh = 0
        self.views: list[View] = []
        self.category: list[str] = []
        self.instances: dict[str, list[int]] = {}
        self._grow(64)

    def _grow(self, capacity: int) -> None:
        old = len(self.category)
        blank: dict[str, NDArray[Any]] = {
            "box": np.tile(np.array([1e3, 1e3, 1e3, -1e3, -1e3, -1e3]), (capacity, 1)),
            "kind": np.zeros(capacity, np.uint8),
            "opened": np.zeros(capacity, bool),
            "pixels": np.zeros(capacity, np.int32),
            "last_seen": np.full(capacity, -1, np.int32),
        }
        for name, array in blank.items():
            if old:
                array[:old] = getattr(self, name)[:old]
            setattr(self, name, array)

    box: NDArray[np.float64]
    kind: NDArray[np.uint8]
    opened: NDArray[np.bool_]
    pixels: NDArray[np.int32]
    last_seen: NDArray[np.int32]

    @property
    def n_tracks(self) -> int:
        """Tracks known so far."""
        return len(self.category)

    @property
    def view(self) -> View:
        """Where the agent is."""
        return self.views[-1]

    def update(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> None:
        """Add one frame: ``observation`` depth, pose, collision; ``info`` detections, tracks, opened.

        Raises:
            ConfigError: no view of 90 degrees.
        """
        require_right_angle(info)
        view = view_of_pose(observation["pose"], float(info.get("camera_m", self.body.camera_m)), self.body)
        if self.views and bool(observation["collision"]):
            self._bump(self.view)
        self.views.append(view)
        self.step = len(self.views) - 1
        detections = Detections.from_info(info)
        self._register(detections)
        for track in info.get("opened", ()):
            if 0 <= int(track) < self.n_tracks:
                self.opened[int(track)] = True
        depth = frame_depth(observation, info)
        self._integrate(view, depth, detections.image)

    def tour(self, frames: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> None:
        """Learn the home before the search begins, from observations and infos of a walk through it."""
        for observation, info in frames:
            self.update(observation, info)
        self.views.clear()
        self.visited[:], self.pixels[:], self.last_seen[:] = 0, 0, -1

    def _register(self, detections: Detections) -> None:
        self.pixels[:] = 0
        if not len(detections.track):
            return
        last = int(detections.track.max())
        if last >= len(self.kind):
            self._grow(2 * last + 2)
        self.category.extend([""] * (last + 1 - self.n_tracks))
        for track, name, pixels in zip(
            detections.track.tolist(), detections.category, detections.pixels.tolist(), strict=True
        ):
            if pixels < MIN_PIXELS:
                continue
            if not self.category[track]:
                self.category[track] = name
                self.kind[track] = STRUCTURE_KINDS.get(name, 0)
                self.instances.setdefault(name, []).append(track)
            self.pixels[track] = pixels
            self.last_seen[track] = self.step

    def _integrate(self, view: View, depth: NDArray[np.float32], image: NDArray[np.int16]) -> None:
        n = self.n_tracks
        cells = (self.height, self.near, self.floor, self.blocked, self.walls)
        camera = camera_of(view, depth, self.body)
        kernels.integrate(depth, image, camera, HALF, cells, self.kind[:n], self.opened[:n], self.box[:n])
        self.fresh = int(kernels.carve(depth, camera, HALF, self.explored, CARVE_M))
        self.visited[view.i, view.j] = 1
        self.explored[view.i, view.j] = 1

    def _bump(self, view: View) -> None:
        i, j = view.i + (1, 0, -1, 0)[view.heading], view.j + (0, 1, 0, -1)[view.heading]
        if 0 <= i < SIZE and 0 <= j < SIZE:
            self.bumped[i, j] = 1

    def seen(self, track: int) -> bool:
        """Whether any pixel of a track has been placed in space."""
        return bool(self.box[track, 3] >= self.box[track, 0])

    def cells_of(self, tracks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Cells (n, 2) in which the middles of what was seen of some tracks lie."""
        boxes = self.box[tracks]
        middle = np.floor(0.5 * (boxes[:, :2] + boxes[:, 3:5]) / CELL_M + 0.5).astype(np.int64) + HALF
        return np.clip(middle, 0, SIZE - 1)

    def gap_m(self, track: int, xy: tuple[float, float]) -> float:
        """Horizontal metres from a point to the box of a track as far as it was seen (never less than the truth)."""
        x0, y0, _, x1, y1, _ = self.box[track]
        return float(np.hypot(max(x0 - xy[0], xy[0] - x1, 0.0), max(y0 - xy[1], xy[1] - y1, 0.0)))

    def passable(self) -> NDArray[np.bool_]:
        """(257, 257) nodes not known to be impassable; unknown ones count as passable until seen or bumped into."""
        free = (self.blocked == 0) & (self.bumped == 0)
        free[self.visited > 0] = True
        return free

    def extent(self, margin: int = 2) -> tuple[int, int, int, int]:
        """Cells (i0, i1, j0, j1), ends excluded, that hold all that was explored, grown by ``margin``."""
        rows, columns = np.flatnonzero(self.explored.any(1)), np.flatnonzero(self.explored.any(0))
        return (
            max(1, int(rows[0]) - margin),
            min(SIZE - 1, int(rows[-1]) + margin + 1),
            max(1, int(columns[0]) - margin),
            min(SIZE - 1, int(columns[-1]) + margin + 1),
        )


def require_right_angle(info: Mapping[str, Any]) -> None:
    """Refuse frames that are not 90 degrees wide: what is mapped, and when a place counts as seen, is made for those.

    Raises:
        ConfigError: saying what to give.
    """
    if (fov_deg := float(info.get("fov_deg", _FOV_DEG))) != _FOV_DEG:
        raise ConfigError(f"env.fov_deg={fov_deg:g}: agents that map see {_FOV_DEG:g} degrees; leave it at that")


def frame_depth(observation: Mapping[str, Any], info: Mapping[str, Any]) -> NDArray[np.float32]:
    """Depth image (H, W) of an observation; symbolic environments put it into ``info``."""
    depth: NDArray[np.float32] = observation["depth"] if "depth" in observation else info["depth"]
    return depth.reshape(depth.shape[:2])


def camera_of(view: View, depth: NDArray[np.float32], body: Body) -> NDArray[np.float64]:
    """The kernels' camera of a view; pixels are square and the image is 90 degrees wide."""
    x, y = view.xy
    c, s = HEADING_COS[view.heading], HEADING_SIN[view.heading]
    camera_m, pitch_deg = body.eyes[view.pitch_deg]
    return np.array([x, y, camera_m, c, s, *_PITCH[pitch_deg], 0.5 * depth.shape[1]])


def view_of_pose(
    pose: NDArray[np.floating[Any]], camera_m: float = PAPER_BODY.camera_m, body: Body = PAPER_BODY
) -> View:
    """Nearest grid pose of (x, y, yaw_rad, pitch_rad) and the camera's height."""
    x, y, yaw, pitch = pose.tolist()
    heading = round(yaw / (np.pi / 2)) % 4
    look = body.look(camera_m, round(np.rad2deg(pitch) / 30) * 30)
    return View(round(x / CELL_M) + HALF, round(y / CELL_M) + HALF, heading, look)
