"""The shortest legal solution of a search, found by rendering every pose from which it could succeed.

The shortest path l counts the metres moved. For a target behind a closed door the path leads to a node where Open works
on its container, and then to a node, heading and view where Done succeeds. Whatever else the same Open would open is
opened too, so that the solution is legal and the oracle can execute it as stored.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ucon.scenes.spec import GRID_M
from ucon.sim.paths import distances
from ucon.task.actions import AHEAD, Action
from ucon.task.rules import TaskRules
from ucon.task.search import Eyes, Pose, SceneWorld

#: How many sets of containers that one Open can open are tried at most, the smallest first.
MAX_OPEN_SETS = 6


@dataclass(frozen=True)
class Solution:
    """A shortest legal action sequence that ends in Done.

    Attributes:
        actions: numbers from 0 to 6.
        moves: MoveAhead actions among them.
    """

    actions: tuple[int, ...]
    moves: int

    @property
    def path_m(self) -> float:
        """Path length in metres."""
        return self.moves * GRID_M

    @property
    def digits(self) -> str:
        """The actions as a string of digits."""
        return "".join(map(str, self.actions))


class Solver:
    """Goal poses of one target in one arrangement, and shortest solutions from any start."""

    def __init__(self, world: SceneWorld, eyes: Eyes, target: int, rules: TaskRules) -> None:
        """Set the search up; nothing is rendered yet.

        Args:
            world: the home and what was placed in it.
            eyes: a renderer with this world loaded.
            target: instance of the target.
            rules: the rule set.
        """
        self.world, self.eyes, self.target, self.rules = world, eyes, target, rules

    @cached_property
    def direct(self) -> dict[tuple[int, int], Pose]:
        """For each node, a pose at which Done succeeds with every container closed."""
        return self._done_poses(())

    @cached_property
    def opened(self) -> list[tuple[dict[tuple[int, int], Pose], dict[tuple[int, int], Pose]]]:
        """For each set of containers that one Open opens, two dictionaries from node to pose.

        The first has the poses at which Open opens this set, the second those at which Done then succeeds.
        """
        holder = self._holder()
        if holder < 0:
            return []
        both = [(poses, self._done_poses(instances)) for instances, poses in self._open_sets(holder)]
        return [(poses, done) for poses, done in both if done]

    @property
    def findable(self) -> bool:
        """Whether the target is visible and within reach from any pose with its container open; stops at the first."""
        holder = self._holder()
        opened = (holder,) if holder >= 0 else ()
        self._set_open(opened, 1.0)
        found = next(self._successes(), None) is not None
        self._set_open(opened, 0.0)
        return found

    @property
    def solvable(self) -> bool:
        """Whether Done can succeed at all."""
        return bool(self.direct or self.opened)

    def field(self) -> NDArray[np.int32]:
        """Moves needed from every node.

        Returns:
            (nx, ny) int32; -1 where success cannot be reached.
        """
        fields = [distances(self.world.free, *_sources(self.direct))] if self.direct else []
        for opening, done in self.opened:
            after = distances(self.world.free, *_sources(done))
            usable = {cell: pose for cell, pose in opening.items() if after[cell] >= 0}
            if usable:
                costs = np.array([after[cell] for cell in usable], np.int32)
                fields.append(distances(self.world.free, _cells(usable), costs))
        best = np.full(self.world.free.shape, -1, np.int32)
        for moves in fields:
            better = (moves >= 0) & ((best < 0) | (moves < best))
            best[better] = moves[better]
        return best

    def solve(self, start: Pose) -> Solution | None:
        """A shortest solution from a pose, or None; of equally short ones found, the one with the fewest steps."""
        best: Solution | None = None
        for solution in self._solutions(start):
            if best is None or (solution.moves, len(solution.actions)) < (best.moves, len(best.actions)):
                best = solution
        return best

    def _solutions(self, start: Pose) -> Iterator[Solution]:
        """A solution without Open, and one for each set of containers."""
        free = self.world.free
        here = (start.i, start.j)
        if self.direct:
            field = distances(free, *_sources(self.direct))
            if field[here] >= 0:
                yield self._finish(start, field, self.direct, [], 0)
        for opening, done in self.opened:
            after = distances(free, *_sources(done))
            usable = {cell: pose for cell, pose in opening.items() if after[cell] >= 0}
            if not usable:
                continue
            costs = np.array([after[cell] for cell in usable], np.int32)
            field = distances(free, _cells(usable), costs)
            if field[here] < 0:
                continue
            # Walk down to the first node where opening is at least as good as walking on.
            actions, at, moves = _walk(field, start, stop=lambda c, a=after, u=usable, f=field: c in u and a[c] == f[c])
            pose = usable[at.i, at.j]
            actions += _aim(at, pose, self.rules)
            actions.append(int(Action.OPEN))
            yield self._finish(pose, after, done, actions, moves)

    def _finish(
        self, at: Pose, field: NDArray[np.int32], done: dict[tuple[int, int], Pose], actions: list[int], moves: int
    ) -> Solution:
        """Append the actions from a pose to a successful Done."""
        more, pose, walked = _walk(field, at, stop=lambda c: c in done)
        end = _aim(pose, done[pose.i, pose.j], self.rules)
        return Solution(tuple(actions + more + end + [int(Action.DONE)]), moves + walked)

    def _holder(self) -> int:
        """The closed container that the target is in; -1 for none."""
        holder = self.world.arrangement.objects[self.target - self.world.house.n_instances].holder
        return holder if holder >= 0 and self.world.openable[holder] else -1

    def near_nodes(self, instance: int) -> list[tuple[int, int]]:
        """Free nodes within reach of an instance's box, the nearest to its centre first."""
        grid, box = self.world.house.grid, self.world.boxes[instance : instance + 1]
        reach = self.rules.near_m + GRID_M
        low = grid.cell((box[0, 0] - reach, box[0, 1] - reach))
        high = grid.cell((box[0, 3] + reach, box[0, 4] + reach))
        center = (box[0, :2] + box[0, 3:5]) / 2
        found = []
        for i in range(max(low[0], 0), min(high[0] + 1, grid.shape[0])):
            for j in range(max(low[1], 0), min(high[1] + 1, grid.shape[1])):
                xy = grid.xy((i, j))
                if self.world.free[i, j] and self.rules.near(xy, box)[0]:
                    found.append((float(np.hypot(*(xy - center))), i, j))
        return [(i, j) for _, i, j in sorted(found)]

    def facing(self, node: tuple[int, int], instance: int) -> Iterator[Pose]:
        """Poses at a node whose 90 degree view can contain part of an instance's box, the level ones first."""
        x, y = self.world.house.grid.xy(node)
        box = self.world.boxes[instance]
        xs, ys, zs = (box[0] - x, box[3] - x), (box[1] - y, box[4] - y), (box[2], box[5])
        for height, pitch in self.rules.views:
            z = self.rules.camera_heights_m[height]
            for heading in range(4):
                ahead = AHEAD[heading]
                if box_in_view(xs, ys, (zs[0] - z, zs[1] - z), ahead, pitch):
                    yield Pose(*node, heading, height, pitch)

    def counts(self, pose: Pose) -> NDArray[np.int32]:
        """(n,) pixels of every instance in the canonical view of a pose."""
        x, y = self.world.house.grid.xy((pose.i, pose.j))
        z = self.rules.camera_heights_m[pose.height]
        return self.eyes.visible(float(x), float(y), z, pose.heading, pose.pitch_deg)

    def _done_poses(self, opened: tuple[int, ...]) -> dict[tuple[int, int], Pose]:
        """For each node, a pose at which Done succeeds with the given containers open."""
        self._set_open(opened, 1.0)
        poses = {(pose.i, pose.j): pose for pose in self._successes()}
        self._set_open(opened, 0.0)
        return poses

    def _successes(self) -> Iterator[Pose]:
        """One successful pose for each node in the current state, the nearest nodes first."""
        for node in self.near_nodes(self.target):
            for pose in self.facing(node, self.target):
                if self.counts(pose)[self.target] >= self.rules.done_min_pixels:
                    yield pose
                    break

    def _open_sets(self, holder: int) -> list[tuple[tuple[int, ...], dict[tuple[int, int], Pose]]]:
        """Sets of containers that one Open opens, ``holder`` among them, with the poses at which it does so."""
        sets: dict[tuple[int, ...], dict[tuple[int, int], Pose]] = {}
        openable = np.flatnonzero(self.world.openable)
        for node in self.near_nodes(holder):
            near = openable[self.rules.near(self.world.house.grid.xy(node), self.world.boxes[openable])]
            for pose in self._opening_poses(node, holder):
                opened = near
                if self.rules.open_needs_sight:
                    opened = near[self.counts(pose)[near] >= self.rules.open_min_pixels]
                if holder in opened:
                    sets.setdefault(tuple(int(k) for k in opened), {}).setdefault(node, pose)
        ranked = sorted(sets.items(), key=lambda item: (len(item[0]), -len(item[1]), item[0]))
        return ranked[:MAX_OPEN_SETS]

    def _opening_poses(self, node: tuple[int, int], holder: int) -> Iterator[Pose]:
        """Poses at a node from which Open may work on a container; where Open needs no sight, one pose is enough."""
        yield from self.facing(node, holder)
        if not self.rules.open_needs_sight:
            yield Pose(*node, heading=0)

    def _set_open(self, instances: tuple[int, ...], fraction: float) -> None:
        """Show containers opened by a fraction."""
        for instance in instances:
            self.eyes.set_open(instance, fraction)


def box_in_view(
    xs: tuple[float, float],
    ys: tuple[float, float],
    zs: tuple[float, float],
    ahead: tuple[float, float],
    pitch_deg: int,
    tan_half: float = 1.0,
) -> bool:
    """Whether part of a box may be in view: False only if all its corners are outside the same plane of the view.

    Args:
        xs: least and greatest x of the box, metres relative to the camera.
        ys: least and greatest y.
        zs: least and greatest z.
        ahead: cosine and sine of the yaw.
        pitch_deg: up positive.
        tan_half: tangent of half the angle of view.
    """
    c, s = np.cos(np.radians(pitch_deg)), np.sin(np.radians(pitch_deg))
    fx, fy = ahead
    outside = np.zeros(5, int)
    for x in xs:
        for y in ys:
            for z in zs:
                level, side = x * fx + y * fy, -x * fy + y * fx
                front, up = c * level + s * z, c * z - s * level
                edge = tan_half * front
                outside += (front <= 0, side > edge, -side > edge, up > edge, -up > edge)
    return bool((outside < 8).all())


def _cells(poses: dict[tuple[int, int], Pose]) -> NDArray[np.int64]:
    """The nodes of the poses, (n, 2)."""
    return np.array(list(poses), np.int64).reshape(-1, 2)


def _sources(poses: dict[tuple[int, int], Pose]) -> tuple[NDArray[np.int64], None]:
    """The arguments of :func:`distances` for poses without costs."""
    return _cells(poses), None


def _walk(field: NDArray[np.int32], start: Pose, stop) -> tuple[list[int], Pose, int]:  # type: ignore[no-untyped-def]
    """Follow a distance field down until ``stop(cell)``, straight where possible; actions, pose there and moves."""
    actions: list[int] = []
    i, j, heading, moves = start.i, start.j, start.heading, 0
    nx, ny = field.shape
    while not stop((i, j)):
        for turn in (0, 1, 3, 2):
            di, dj = AHEAD[(heading + turn) % 4]
            ni, nj = i + di, j + dj
            if 0 <= ni < nx and 0 <= nj < ny and 0 <= field[ni, nj] == field[i, j] - 1:
                break
        else:
            raise RuntimeError("a distance field without a way down")
        actions += [*_turns(turn), int(Action.MOVE_AHEAD)]
        i, j, heading, moves = ni, nj, (heading + turn) % 4, moves + 1
    return actions, Pose(i, j, heading, start.height, start.pitch_deg), moves


def _turns(turn: int) -> list[int]:
    """Rotations for a number of quarter turns counter-clockwise."""
    if turn == 3:
        return [int(Action.ROTATE_RIGHT)]
    return [int(Action.ROTATE_LEFT)] * turn


def _aim(at: Pose, goal: Pose, rules: TaskRules) -> list[int]:
    """Rotations and looks from one view to another at the same node."""
    if rules.look_moves_camera:
        looks = goal.height - at.height
    else:
        looks = (goal.pitch_deg - at.pitch_deg) // rules.pitch_step_deg
    look = Action.LOOK_UP if looks > 0 else Action.LOOK_DOWN
    return _turns((goal.heading - at.heading) % 4) + [int(look)] * abs(looks)
