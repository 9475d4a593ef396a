"""The 0.25 m semantic map that an agent builds from its own frames: cells, tracked things, and poses.

The start frame: the agent's first pose is the origin and looks along +x; y is to its left, z up from the floor. Cells
are centred on the nodes where the agent can stand. The map covers 64 m x 64 m, more than any home; what lies outside is
ignored.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import TAN_HALF
from ucon.core.errors import ConfigError
from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.core.sharing import PartlyShared, Shared
from ucon.objects.catalogue import catalogue
from ucon.perception.errors.model import DetectorErrors
from ucon.perception.hypotheses.hypotheses import Hypotheses, name_rows
from ucon.perception.mapping import map_kernels as kernels
from ucon.perception.mapping.body import PAPER_BODY, Body
from ucon.perception.mapping.detections import MIN_PIXELS, STRUCTURE_KINDS, Detections
from ucon.perception.mapping.obstacles import ObstacleMap
from ucon.perception.mapping.settling import IN_VAIN, LookBoxes, United

CELL_M = kernels.CELL_M
#: Cell number of the start, in i and j.
HALF = 128
#: Cells of a side.
SIZE = 2 * HALF + 1
#: Cells under a sight line count as explored up to this many metres from the camera.
CARVE_M = 8.0
#: What to do where the errors of a detector are not known.
NO_ERRORS = (
    "its errors are unknown, and agents that keep a map need them; fit them on training homes: "
    "python -m ucon detector fit {} FILE, then detector.errors=FILE"
)
#: Points that a real camera sees at more than this depth are too uncertain for the cells of the map, metres.
SURE_M = 4.0
#: Box of a track of which no point was seen.
_NO_BOX = np.array([1e3, 1e3, 1e3, -1e3, -1e3, -1e3])
_PITCH = {p: (float(np.cos(np.deg2rad(p))), float(np.sin(np.deg2rad(p)))) for p in (-60, -30, 0, 30, 60)}


@dataclass(frozen=True, slots=True)
class View(Shared):
    """A pose of the agent on the grid.

    Attributes:
        i: cell along x.
        j: cell along y.
        heading: number of turns counter-clockwise from +x, of 90 degrees each (60 for the real robot).
        pitch_deg: degrees, up positive. Under rules that move the camera instead, the look of
            :class:`~ucon.perception.mapping.body.Body`.
        at: x, y in metres and yaw in radians of a robot that stands between nodes; None on a node.
    """

    i: int
    j: int
    heading: int
    pitch_deg: int = 0
    at: tuple[float, float, float] | None = field(default=None, compare=False)

    @property
    def xy(self) -> tuple[float, float]:
        """Position (x, y) in metres in the start frame."""
        return self.node_xy if self.at is None else self.at[:2]

    @property
    def node_xy(self) -> tuple[float, float]:
        """Position (x, y) of the node in metres in the start frame; views are valued from there."""
        return (self.i - HALF) * CELL_M, (self.j - HALF) * CELL_M

    @property
    def direction(self) -> tuple[float, float]:
        """Cosine and sine of the yaw."""
        if self.at is None:
            return HEADING_COS[self.heading], HEADING_SIN[self.heading]
        return float(np.cos(self.at[2])), float(np.sin(self.at[2]))

    @property
    def quarter(self) -> int:
        """The yaw as the nearest number of quarter turns."""
        return self.heading if self.at is None else round(self.at[2] / (np.pi / 2)) % 4


class SemanticMap(PartlyShared):
    """Everything one agent has seen in one episode. Grids are (257, 257), indexed [i, j] = [x, y]; T tracks.

    Attributes:
        body: the agent's camera and reach.
        explored: uint8 grid, 1 where a sight line passed over the cell.
        visited: uint8 grid, 1 where the agent stood.
        height: float32 grid, the highest point seen in the cell below 1.9 m, metres; -1 where none was seen.
        near: float32 grid, the least optical depth at which a point in the cell was seen, metres.
        floor: uint8 grid, 1 where floor was seen.
        walls: (2, 257, 257) uint8, 1 where a wall stands between (i, j) and (i + 1, j), or (i, j + 1).
        blocked: uint8 grid, 1 where an obstacle was seen within the robot's radius of the node.
        bumped: uint8 grid, 1 where a move to the node failed.
        category: name of each of the T tracks, "" until detected.
        instances: tracks by category.
        kind: (>= T,) uint8, 0 for things, else the code in ``STRUCTURE_KINDS``.
        box: (>= T, 6) float64, x0 y0 z0 x1 y1 z1 of the points seen, metres.
        opened: (>= T,) bool, whether an Open opened it.
        pixels: (>= T,) int32, pixels in the last frame.
        last_seen: (>= T,) int32, step at which it was last in view, -1 never.
        views: poses so far, one a step.
        step: number of the last frame, from 0.
        fresh: how many cells the last frame explored.
        inexact: whether boxes may hold parts of other things: the detector finds boxes, or the body is not exact.
        hypotheses: what the tracks may be, where the detector errs; None where it does not.
        named_at: (>= T,) int32, step at which the name of a track last changed, -1 never.
        stale: (>= T,) bool, things last seen in an earlier search of this home, which may have been moved since.
        obstacles: what a robot that moves continuously steers around; None on the grid.
        lived_in: whether earlier searches mapped this home, so that furniture was seen from all sides.
        looks: what single looks showed, where the map is kept for further searches and the detector errs.
        united: which of the detector's tracks are one thing.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"views", "category"})

    def __init__(
        self, body: Body = PAPER_BODY, errors: DetectorErrors | None = None, target: str = "", *, kept: bool = False
    ) -> None:
        """Start with an empty map.

        Args:
            body: the agent's camera and reach; those of the paper's rules by default.
            errors: of the detector, where it errs.
            target: what is searched for.
            kept: whether the map is kept for further searches.
        """
        self.body = body
        self.looks = LookBoxes(errors) if kept and errors is not None else None
        self.united = United()
        self.hypotheses = None if errors is None else Hypotheses(errors, target)
        self.obstacles = None if body.exact else ObstacleMap()

        def grid(dtype: type, fill: float = 0) -> NDArray[Any]:
            return np.full((SIZE, SIZE), fill, dtype)

        self.explored, self.floor, self.blocked, self.bumped, self.visited = (grid(np.uint8) for _ in range(5))
        self.height = grid(np.float32, -1.0)
        self.near = grid(np.float32, 1e3)
        self.walls = np.zeros((2, SIZE, SIZE), np.uint8)
        self.step = 0
        self.fresh = 0
        self.lived_in = False
        self.inexact = not body.exact
        self._nearest: NDArray[np.float32] | None = None
        self._sought = {target}
        self.views: list[View] = []
        self.category: list[str] = []
        self.instances: dict[str, list[int]] = {}
        self._grow(64)

    @classmethod
    def of(cls, info: Mapping[str, Any]) -> SemanticMap:
        """The map with which an episode begins: the kept one of a robot that lives in the home, else an empty one.

        Args:
            info: of the reset: ``task``, ``target`` and, where there are any, ``detector_errors`` and ``kept_map``.
        """
        kept = info.get("kept_map")
        if isinstance(kept, cls):
            return kept
        return cls(Body.of(info), info.get("detector_errors"), str(info["target"]))

    def _grow(self, capacity: int) -> None:
        """Give the arrays of tracks room for ``capacity`` rows."""
        old = len(self.category)
        blank: dict[str, NDArray[Any]] = {
            "box": np.tile(_NO_BOX, (capacity, 1)),
            "kind": np.zeros(capacity, np.uint8),
            "opened": np.zeros(capacity, bool),
            "pixels": np.zeros(capacity, np.int32),
            "last_seen": np.full(capacity, -1, np.int32),
            "named_at": np.full(capacity, -1, np.int32),
            "stale": np.zeros(capacity, bool),
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
    named_at: NDArray[np.int32]
    stale: NDArray[np.bool_]

    @property
    def n_tracks(self) -> int:
        """Number T of tracks so far."""
        return len(self.category)

    @property
    def view(self) -> View:
        """The agent's current pose."""
        return self.views[-1]

    def update(self, observation: Mapping[str, Any], info: Mapping[str, Any]) -> None:
        """Add one frame.

        Args:
            observation: ``depth`` (unless ``info`` has it), ``pose``, ``collision``.
            info: ``detections``, ``tracks`` and, where there are any, ``opened``, ``camera_m``, ``fov_deg``.

        Raises:
            ConfigError: the view is not as wide as the body's.
        """
        require_width(info, self.body.fov_deg)
        view = view_of_pose(observation["pose"], float(info.get("camera_m", self.body.camera_m)), self.body)
        if self.views and bool(observation["collision"]):
            self._bump(self.view)
        self.views.append(view)
        self.step = len(self.views) - 1
        detections = self.united.detections(Detections.from_info(info))
        self.inexact |= detections.score is not None
        self._register(detections)
        for track in map(self.united.of, map(int, info.get("opened", ()))):
            if 0 <= track < self.n_tracks:
                self.opened[track] = True
        depth = frame_depth(observation, info)
        self._integrate(view, depth, detections.image)
        if detections.score is not None:
            self._doubt(detections, depth, info)

    def tour(self, frames: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> None:
        """Learn the home before the search begins; poses and steps are reset afterwards.

        Args:
            frames: observations and infos of a walk through the home.
        """
        for observation, info in frames:
            self.update(observation, info)
        self.views.clear()
        self.visited[:], self.pixels[:], self.last_seen[:] = 0, 0, -1
        self.named_at[self.named_at > 0] = 0

    def search_again(self, target: str) -> None:
        """Begin another search in the same home, later.

        Rooms and furniture stay known, poses and steps start over, and containers count as closed. Small things, and
        all things ever searched for, may have been moved: the target counts as unseen, the others keep their old boxes
        until they are seen again.

        Args:
            target: what is searched for now.
        """
        self.views.clear()
        self.step = self.fresh = 0
        self.lived_in = True
        self.visited[:], self.bumped[:] = 0, 0
        self.pixels[:], self.last_seen[:], self.opened[:] = 0, -1, False
        self.named_at[self.named_at > 0] = 0
        self._sought.add(target)
        self._settle()
        small = [name for name in self.instances if name in self._sought or _is_small(name)]
        tracks = sorted(track for name in small for track in self.instances[name])
        self.stale[tracks] = True
        self.box[self.instances.get(target, [])] = _NO_BOX
        if self.hypotheses is not None:
            self.hypotheses.search_again(target, tracks)
        if self.looks is not None:
            self.looks.forget(tracks)

    def _settle(self) -> None:
        """Give furniture the boxes on which the looks of all searches agree, and keep one track of each thing.

        Tracks that were looked for in vain more often than found are forgotten, and so are things without a name.
        """
        if self.looks is None or self.hypotheses is None:
            return
        rows, n = name_rows(), self.n_tracks
        names = np.array(
            [-1 if name in self._sought or _is_small(name) else rows.get(name, -1) for name in self.category], np.int32
        )
        self.looks.settle(names, self.box)
        found, absent = self.hypotheses.support(n)
        things = self.kind[:n] == 0
        nameless = things & np.array([name == "" for name in self.category], bool)
        lost = nameless | ((names >= 0) & (found + IN_VAIN * absent <= 0.0))
        names[lost] = -1
        gone = [*self.united.unite(self.box[:n], names, found), *np.flatnonzero(lost).tolist()]
        for track in gone:
            self._name(track, "")
        self.box[gone], self.named_at[gone] = _NO_BOX, -1
        self.looks.forget(gone)
        self.hypotheses.forget(gone)

    def _register(self, detections: Detections) -> None:
        """Enter the tracks of a frame: names, pixels, step."""
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
            if self.named_at[track] < 0 and (detections.score is None or name in STRUCTURE_KINDS):
                self.kind[track] = STRUCTURE_KINDS.get(name, 0)
                self._name(track, name)
            if self.stale[track]:
                self.stale[track], self.box[track] = False, _NO_BOX
            self.pixels[track] = pixels
            self.last_seen[track] = self.step

    def _name(self, track: int, name: str) -> None:
        """Call a track by another name; "" where there is probably no thing."""
        if before := self.category[track]:
            self.instances[before].remove(track)
            if not self.instances[before]:
                del self.instances[before]
        self.category[track], self.named_at[track] = name, self.step
        if name:
            self.instances.setdefault(name, []).append(track)

    def _doubt(self, detections: Detections, depth: NDArray[np.float32], info: Mapping[str, Any]) -> None:
        """Update the hypotheses with what the detector calls the things in view."""
        if self.hypotheses is None:
            name = info.get("detector", "of this environment")
            raise ConfigError(f"detector {name}: {NO_ERRORS.format(name)}")
        assert detections.score is not None
        called = {
            track: (name, score)
            for track, name, score, pixels in zip(
                detections.track.tolist(), detections.category, detections.score.tolist(), detections.pixels.tolist(),
                strict=True,
            )
            if pixels >= MIN_PIXELS and name not in STRUCTURE_KINDS and self.seen(track)
        }  # fmt: skip
        n, camera = self.n_tracks, camera_of(self.view, depth, self.body)
        if self.looks is not None:
            names = np.full(n, -1, np.int32)
            names[list(called)] = [name_rows().get(name, -1) for name, _ in called.values()]
            self.looks.look(depth, detections.image, camera, names, self.opened[:n])
        changed = self.hypotheses.look(self.box[:n], self.kind[:n], self.category, called, depth, camera)
        for track, name in changed.items():
            self._name(track, name)
        if self.looks is not None:
            for track in called:
                names[track] = name_rows().get(self.category[track], names[track])
            self.looks.settle(names, self.box)

    def _integrate(self, view: View, depth: NDArray[np.float32], image: NDArray[np.int16]) -> None:
        """Enter the points of a frame: cells, boxes, explored space."""
        n = self.n_tracks
        cells = (self.height, self.near, self.floor, self.blocked, self.walls)
        camera = camera_of(view, depth, self.body)
        far_m = kernels.FAR_M if self.obstacles is None else SURE_M
        kernels.integrate(depth, image, camera, HALF, cells, self.kind[:n], self.opened[:n], self.box[:n], far_m)
        if self.obstacles is not None:
            self.obstacles.add(depth, camera)
            self._nearest = np.empty(n, np.float32)
            kernels.nearest(depth, image, camera, self._nearest)
        self.fresh = int(kernels.carve(depth, camera, HALF, self.explored, CARVE_M))
        self.visited[view.i, view.j] = 1
        self.explored[view.i, view.j] = 1

    def _bump(self, view: View) -> None:
        """Mark the node ahead of a pose: a move to it failed."""
        if self.obstacles is not None:
            self.obstacles.bump(view.xy, view.direction)
            return
        i, j = view.i + (1, 0, -1, 0)[view.heading], view.j + (0, 1, 0, -1)[view.heading]
        if 0 <= i < SIZE and 0 <= j < SIZE:
            self.bumped[i, j] = 1

    def seen(self, track: int) -> bool:
        """Whether any point of a track was seen, so that its box is valid."""
        return bool(self.box[track, 3] >= self.box[track, 0])

    def cells_of(self, tracks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Cells in which the centres of tracks' boxes lie.

        Args:
            tracks: (n,) track numbers.

        Returns:
            (n, 2) int64.
        """
        boxes = self.box[tracks]
        middle = np.floor(0.5 * (boxes[:, :2] + boxes[:, 3:5]) / CELL_M + 0.5).astype(np.int64) + HALF
        return np.clip(middle, 0, SIZE - 1)

    def gap_m(self, track: int, xy: tuple[float, float]) -> float:
        """Horizontal distance in metres from a point to what was seen of a track.

        It is never less than the distance to the whole thing.

        Args:
            track: its number.
            xy: the point, metres in the start frame.
        """
        x0, y0, _, x1, y1, _ = self.box[track]
        return float(np.hypot(max(x0 - xy[0], xy[0] - x1, 0.0), max(y0 - xy[1], xy[1] - y1, 0.0)))

    def gap_now_m(self, track: int) -> float:
        """Horizontal distance in metres from the agent to what was seen of a track.

        For a robot, whose pose drifts, only the part of the track in view counts, if there is one.

        Args:
            track: its number.
        """
        if self._nearest is not None and track < len(self._nearest) and np.isfinite(self._nearest[track]):
            return float(self._nearest[track])
        return self.gap_m(track, self.view.xy)

    def passable(self) -> NDArray[np.bool_]:
        """Nodes not known to be impassable; unexplored ones count as passable until seen or bumped into.

        Returns:
            (257, 257) bool.
        """
        free = (self.blocked == 0) & (self.bumped == 0)
        free[self.visited > 0] = True
        return free

    def extent(self, margin: int = 2) -> tuple[int, int, int, int]:
        """The smallest box of cells that holds everything explored, grown by ``margin`` cells and clipped to the map.

        Returns:
            (i0, i1, j0, j1), ends excluded.
        """
        rows, columns = np.flatnonzero(self.explored.any(1)), np.flatnonzero(self.explored.any(0))
        return (
            max(1, int(rows[0]) - margin),
            min(SIZE - 1, int(rows[-1]) + margin + 1),
            max(1, int(columns[0]) - margin),
            min(SIZE - 1, int(columns[-1]) + margin + 1),
        )


def _is_small(name: str) -> bool:
    """Whether things of a category are small enough to be carried about."""
    return name in catalogue() and catalogue()[name].role == "movable"


def require_width(info: Mapping[str, Any], fov_deg: float = 90.0) -> None:
    """Check that a frame's view is as wide as the task's, for which maps and their thresholds are made.

    Args:
        info: of a frame; ``fov_deg`` is the task's by default.
        fov_deg: the task's width, degrees.

    Raises:
        ConfigError: the view has another width.
    """
    if (given := float(info.get("fov_deg", fov_deg))) != fov_deg:
        raise ConfigError(
            f"env.fov_deg={given:g}: agents that keep a map need {fov_deg:g} degrees here; leave it at that"
        )


def frame_depth(observation: Mapping[str, Any], info: Mapping[str, Any]) -> NDArray[np.float32]:
    """Depth image of a frame.

    Args:
        observation: has ``depth``, (H, W) or (H, W, 1), in visual environments.
        info: has ``depth`` in symbolic environments.

    Returns:
        (H, W) float32, metres along the optical axis.
    """
    depth: NDArray[np.float32] = observation["depth"] if "depth" in observation else info["depth"]
    return depth.reshape(depth.shape[:2])


def camera_of(view: View, depth: NDArray[np.float32], body: Body) -> NDArray[np.float64]:
    """The camera as the kernels take it; the image is as wide as the body's views and its pixels are square.

    Args:
        view: the agent's pose.
        depth: (H, W), for its width.
        body: height and pitch of every look.

    Returns:
        (8,) float64: x, y, z, cos yaw, sin yaw, cos pitch, sin pitch, focal length in pixels.
    """
    x, y = view.xy
    c, s = view.direction
    camera_m, pitch_deg = body.eyes[view.pitch_deg]
    return np.array([x, y, camera_m, c, s, *_PITCH[pitch_deg], 0.5 * depth.shape[1] / TAN_HALF[body.headings]])


def view_of_pose(
    pose: NDArray[np.floating[Any]], camera_m: float = PAPER_BODY.camera_m, body: Body = PAPER_BODY
) -> View:
    """The nearest pose on the grid.

    Args:
        pose: (4,) x, y in metres, yaw, pitch in radians, in the start frame.
        camera_m: height of the camera in metres.
        body: heights and pitches of the camera.
    """
    x, y, yaw, pitch = pose.tolist()
    heading = round(yaw * body.headings / (2.0 * np.pi)) % body.headings
    look = body.look(camera_m, round(np.rad2deg(pitch) / 30) * 30)
    if body.exact:
        return View(round(x / CELL_M) + HALF, round(y / CELL_M) + HALF, heading, look)
    # As the kernels do: a robot's moves of 0.125 m to the side end on the edges of cells.
    i, j = (math.floor(v / CELL_M + 0.5) + HALF for v in (x, y))
    return View(i, j, heading, look, (x, y, yaw))
