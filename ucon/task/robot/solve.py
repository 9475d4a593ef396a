"""Shortest paths to success for a robot that moves continuously, and a solution that it can carry out.

Two sets of places are searched. The shortest path l of SPL goes over the fine grid of :class:`PathGrid`: it is the
body's shortest path, whatever the actions are. The stored solution goes over the :class:`Lattice` that a robot without
errors reaches by whole moves, and is therefore longer. On both, a way leads to the nearest place from which Done
succeeds; if the target is behind a closed door, it leads via a place from which Open opens that door.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ucon.sim.render.base import heading_cos_sin, tan_half
from ucon.sim.robot.field import PathGrid
from ucon.sim.robot.floor import Floor
from ucon.sim.robot.lattice import HEADINGS, MOVE_COST, NEVER, Lattice
from ucon.task.actions import Action
from ucon.task.robot.pose import RobotPose
from ucon.task.robot.search import MOVE_M
from ucon.task.rules import TaskRules
from ucon.task.search import Eyes, SceneWorld
from ucon.task.solve import Solution, box_in_view

#: A view: heading (number of turns to the left from the start's heading) and pitch in degrees.
View: TypeAlias = tuple[int, int]
#: Indices of a place.
Place: TypeAlias = tuple[int, int]
#: Spacing in cells of the places that are tested for whether a target can be found at all; equals 0.25 m.
_SPARSE = 5


@dataclass(frozen=True)
class Way:
    """A way to success: where Done is called, and where Open is called before (None: not at all)."""

    length_m: float
    end: Place
    view: View
    opening: Place | None = None
    opening_view: View = (0, 0)


class Places(Protocol):
    """Places that can be reached, and how far they are."""

    def near(self, box: NDArray[np.float64], reach_m: float) -> NDArray[np.int64]:
        """(n, 2) the places within ``reach_m`` of a box (6,) in x and in y."""

    def xy(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 2) world metres of places (n, 2)."""

    def metres(self, origin: Place | None, places: NDArray[np.int64], most_m: float) -> NDArray[np.float64]:
        """(n,) metres to places from another one (None: the start); infinity where no path is short enough."""


class RobotSolver:
    """Ways to success for one target in one arrangement, from any start, without errors."""

    def __init__(self, world: SceneWorld, eyes: Eyes, target: int, rules: TaskRules, floor: Floor) -> None:
        """Set the search up; nothing is rendered yet.

        Args:
            world: the home and what was placed in it.
            eyes: a renderer with this world loaded that counts pixels in the rules' view.
            target: instance of the target.
            rules: the rule set.
            floor: what the robot can touch.
        """
        self.world, self.eyes, self.target, self.rules, self.floor = world, eyes, target, rules, floor
        self.grid = PathGrid(floor)
        holder = world.arrangement.objects[target - world.house.n_instances].holder
        self._holder = holder if holder >= 0 and world.openable[holder] else -1

    @property
    def findable(self) -> bool:
        """Whether Done can succeed from anywhere with the target's container open; stops at the first place."""
        places = _GridPlaces(self.grid, None)
        cells = places.near(self.world.boxes[self.target], self.rules.near_m)
        cells = cells[(cells % _SPARSE == 0).all(1)]
        sight = _Sight(self, 0.0)
        opened = frozenset({self._holder} - {-1})
        return any(sight.done_view(xy, opened) is not None for xy in places.xy(cells))

    def solve(self, start: RobotPose) -> tuple[float, Solution] | None:
        """The shortest path in metres and a solution from a pose with pitch 0; None where there is no solution."""
        sight = _Sight(self, start.yaw_deg)
        lattice = Lattice(self.floor, (start.x, start.y), start.yaw_deg, MOVE_M)
        walked = self._way(_LatticePlaces(lattice), sight)
        if walked is None:
            return None
        solution = _solution(lattice, walked, self.rules)
        shortest = self._way(_GridPlaces(self.grid, (start.x, start.y)), sight, walked.length_m)
        length_m = walked.length_m if shortest is None else min(shortest.length_m, walked.length_m)
        return length_m, solution

    def _way(self, places: Places, sight: _Sight, most_m: float = math.inf) -> Way | None:
        """The shortest way to success that is no longer than ``most_m``."""
        goals = _Candidates(places, places.near(self.world.boxes[self.target], self.rules.near_m))
        best: Way | None = None
        for metres, place, xy in goals.by_distance(None, most_m):
            if (view := sight.done_view(xy, frozenset())) is not None:
                best = Way(metres, place, view)
                break
        if self._holder < 0:
            return best
        doors = _Candidates(places, places.near(self.world.boxes[self._holder], self.rules.near_m))
        most_m = most_m if best is None else best.length_m
        for metres, place, xy in doors.by_distance(None, most_m):
            if metres >= most_m:
                break
            for opened, opening_view in sight.opening_views(xy, self._holder).items():
                for more, end, end_xy in goals.by_distance(place, most_m - metres):
                    if metres + more >= most_m:
                        break
                    if (view := sight.done_view(end_xy, opened)) is not None:
                        most_m = metres + more
                        best = Way(most_m, end, view, place, opening_view)
                        break
        return best


class _Candidates:
    """Places near a thing, in the order of their distance."""

    def __init__(self, places: Places, near: NDArray[np.int64]) -> None:
        self._places, self._near = places, near
        self._xy = places.xy(near)

    def by_distance(self, origin: Place | None, most_m: float) -> Iterator[tuple[float, Place, NDArray[np.float64]]]:
        """Metres, indices and position of the places within ``most_m`` of another one, the nearest first."""
        metres = self._places.metres(origin, self._near, most_m)
        for k in np.argsort(metres, kind="stable").tolist():
            if not metres[k] <= most_m or math.isinf(metres[k]):
                return
            yield float(metres[k]), (int(self._near[k, 0]), int(self._near[k, 1])), self._xy[k]


class _Sight:
    """What is visible and within reach from places, at the six headings of a start; results for Done are cached."""

    def __init__(self, solver: RobotSolver, yaw_deg: float) -> None:
        self._world, self._eyes, self._rules, self._target = solver.world, solver.eyes, solver.rules, solver.target
        self._yaws = [(yaw_deg + k * solver.rules.turn_deg) % 360.0 for k in range(HEADINGS)]
        self._done: dict[tuple[float, float, frozenset[int]], View | None] = {}

    def done_view(self, xy: NDArray[np.float64], opened: frozenset[int]) -> View | None:
        """A view at a place in which Done succeeds with these containers open."""
        key = (float(xy[0]), float(xy[1]), opened)
        if key not in self._done:
            self._show(opened, 1.0)
            self._done[key] = self._done_view(xy)
            self._show(opened, 0.0)
        return self._done[key]

    def _done_view(self, xy: NDArray[np.float64]) -> View | None:
        if not self._rules.near(xy, self._world.boxes[self._target : self._target + 1])[0]:
            return None
        seen = (
            v
            for v in self._facing(xy, self._target)
            if self._counts(xy, v)[self._target] >= self._rules.done_min_pixels
        )
        return next(seen, None)

    def opening_views(self, xy: NDArray[np.float64], holder: int) -> dict[frozenset[int], View]:
        """Views at a place in which Open opens ``holder``: one for each set of containers opened at the same time."""
        openable = np.flatnonzero(self._world.openable)
        near = openable[self._rules.near(xy, self._world.boxes[openable])]
        found: dict[frozenset[int], View] = {}
        if holder in near:
            for view in self._facing(xy, holder):
                opened = near[self._counts(xy, view)[near] >= self._rules.open_min_pixels]
                if holder in opened:
                    found.setdefault(frozenset(opened.tolist()), view)
        return found

    def _facing(self, xy: NDArray[np.float64], instance: int) -> Iterator[View]:
        """Views that can contain part of an instance's box, the level ones first."""
        box, tan = self._world.boxes[instance], tan_half(self._rules.fov_deg)
        xs, ys = (box[0] - xy[0], box[3] - xy[0]), (box[1] - xy[1], box[4] - xy[1])
        z = self._rules.camera_heights_m[0]
        for _, pitch in self._rules.views:
            for k, yaw_deg in enumerate(self._yaws):
                if box_in_view(xs, ys, (box[2] - z, box[5] - z), heading_cos_sin(yaw_deg / 90.0), pitch, tan):
                    yield k, pitch

    def _counts(self, xy: NDArray[np.float64], view: View) -> NDArray[np.int32]:
        """(n,) pixels of every instance in the canonical view."""
        heading, z = self._yaws[view[0]] / 90.0, self._rules.camera_heights_m[0]
        return self._eyes.visible(float(xy[0]), float(xy[1]), z, heading, view[1])

    def _show(self, instances: frozenset[int], fraction: float) -> None:
        """Show containers opened by a fraction."""
        for instance in sorted(instances):
            self._eyes.set_open(instance, fraction)


class _GridPlaces:
    """The cells of a path grid, with a start."""

    def __init__(self, grid: PathGrid, start: tuple[float, float] | None) -> None:
        self._grid, self._start = grid, start

    def near(self, box: NDArray[np.float64], reach_m: float) -> NDArray[np.int64]:
        """(n, 2) the passable cells within ``reach_m`` of a box (6,) in x and in y."""
        low = np.maximum(self._grid.cell(box[:2] - reach_m), 0)
        high = np.minimum(self._grid.cell(box[3:5] + reach_m) + 1, self._grid.passable.shape)
        return np.argwhere(self._grid.passable[low[0] : high[0], low[1] : high[1]]) + low

    def xy(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 2) world metres of cells (n, 2)."""
        return self._grid.centres(places)

    def metres(self, origin: Place | None, places: NDArray[np.int64], most_m: float) -> NDArray[np.float64]:
        """(n,) metres to cells from another one, or from the start."""
        start = self._start if origin is None else tuple(self._grid.centres(np.array(origin)).tolist())
        if start is None:
            raise ValueError("a grid without a start has no distances from it")
        return self._grid.field(start[0], start[1], most_m).metres[places[:, 0], places[:, 1]]


class _LatticePlaces:
    """The places of a lattice."""

    def __init__(self, lattice: Lattice) -> None:
        self._lattice = lattice
        self._reached = np.argwhere(lattice.cost.min(2) < NEVER)
        self._at = lattice.xy(self._reached)
        self._known: dict[Place, NDArray[np.int32]] = {}

    def near(self, box: NDArray[np.float64], reach_m: float) -> NDArray[np.int64]:
        """(n, 2) the reached places within ``reach_m`` of a box (6,) in x and in y."""
        inside = (self._at >= box[:2] - reach_m) & (self._at <= box[3:5] + reach_m)
        return self._reached[inside.all(1)]

    def xy(self, places: NDArray[np.int64]) -> NDArray[np.float64]:
        """(n, 2) world metres of places (n, 2)."""
        return self._lattice.xy(places)

    def metres(self, origin: Place | None, places: NDArray[np.int64], most_m: float) -> NDArray[np.float64]:
        """(n,) metres to places from another one, or from the start."""
        cost = self._lattice.cost if origin is None else self._costs(origin)
        moves = cost.min(2)[places[:, 0], places[:, 1]]
        return np.where(moves < NEVER, moves // MOVE_COST * MOVE_M, math.inf)

    def _costs(self, origin: Place) -> NDArray[np.int32]:
        """Costs from a place; computed once. Their moves do not depend on the heading there."""
        if origin not in self._known:
            self._known[origin] = self._lattice.costs_from(origin, 0)
        return self._known[origin]


def _solution(lattice: Lattice, way: Way, rules: TaskRules) -> Solution:
    """The solution for a way over a lattice."""
    actions: list[int] = []
    cost, heading, pitch = lattice.cost, 0, 0
    if way.opening is not None:
        actions += _walk(lattice, cost, way.opening, way.opening_view[0])
        heading, pitch = way.opening_view
        actions += [*_looks(0, pitch, rules), int(Action.OPEN)]
        cost = lattice.costs_from(way.opening, heading)
    actions += _walk(lattice, cost, way.end, way.view[0])
    actions += [*_looks(pitch, way.view[1], rules), int(Action.DONE)]
    return Solution(tuple(actions), actions.count(int(Action.MOVE_AHEAD)))


def _walk(lattice: Lattice, cost: NDArray[np.int32], place: Place, heading: int) -> list[int]:
    """Moves and turns to a place and heading, as actions."""
    turns = {0: Action.MOVE_AHEAD, 1: Action.ROTATE_LEFT, -1: Action.ROTATE_RIGHT}
    return [int(turns[step]) for step in lattice.path(cost, place, heading)]


def _looks(now_deg: int, then_deg: int, rules: TaskRules) -> list[int]:
    """Looks from one pitch to another."""
    looks = (then_deg - now_deg) // rules.pitch_step_deg
    return [int(Action.LOOK_UP if looks > 0 else Action.LOOK_DOWN)] * abs(looks)
