"""The privileged expert, for trainers only: the best next action from any pose, whatever was opened before.

An episode stores one shortest solution from its start. A policy in training leaves that path and needs a label wherever
it is. Of all action sequences that succeed, the expert prefers the fewest moves, and among those the fewest steps. It
computes every view in which Done succeeds, every view in which Open opens the target's container, and the distance to
them from all nodes, headings and views.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import I32, jit
from ucon.sim.cache import load_house
from ucon.sim.paths import distances
from ucon.sim.render import RasterRenderer
from ucon.sim.state import SceneState
from ucon.task.actions import AHEAD, Action
from ucon.task.episode import Episode
from ucon.task.rules import task_rules
from ucon.task.search import Pose, Search
from ucon.task.solve import MAX_OPEN_SETS, Solver

#: Open doors farther from the target than this cannot hide it from an agent within reach. Metres.
_IN_THE_WAY_M = 2.5
_NEVER = np.int32(1 << 29)
#: Order of preference among equally good actions.
_ORDER = (Action.MOVE_AHEAD, Action.ROTATE_RIGHT, Action.ROTATE_LEFT, Action.LOOK_UP, Action.LOOK_DOWN)
#: Node, heading and view (index of height and pitch, from the lowest up).
_At: TypeAlias = tuple[int, int, int, int]


@dataclass(frozen=True)
class _Ends:
    """Poses at which one kind of final action (Done or Open) works, and what remains to be done from there."""

    moves: NDArray[np.int32]
    """(nx, ny, 4, V) moves still needed after this action."""
    steps: NDArray[np.int32]
    """(nx, ny, 4, V) steps still needed, this action included."""

    @classmethod
    def none(cls, shape: tuple[int, ...]) -> _Ends:
        """No such pose."""
        return cls(np.full(shape, _NEVER), np.full(shape, _NEVER))


@dataclass(frozen=True)
class _Plan:
    """Moves and steps to success from every pose, for one set of open containers."""

    moves: NDArray[np.int32]
    """(nx, ny) fewest moves to success; -1 where there is no path."""
    steps: NDArray[np.int32]
    """(nx, ny, 4, V) fewest steps among paths with the fewest moves."""
    done: _Ends
    opening: _Ends


class Expert:
    """Knows the best next action from every pose of one episode."""

    def __init__(self, episode: Episode, eyes: RasterRenderer | None = None) -> None:
        """Load the episode's home.

        Args:
            episode: the episode, solved under its own rules.
            eyes: a renderer; the episode's home is loaded into it, so it must not be in use elsewhere.

        Raises:
            ConfigError: the episode's rules have no grid.
        """
        self.rules = task_rules(episode.task)
        self.rules.require_grid(f"episode {episode.id}: the expert needs shortest solutions on the grid")
        house = load_house(episode.scene)
        self._eyes = eyes or RasterRenderer()
        self._eyes.load(house, episode.arrangement)
        self._world = SceneState(house, episode.arrangement)
        self._target = house.n_instances + episode.target
        self._solver = Solver(self._world, self._eyes, self._target, self.rules)
        self._views = sorted(self.rules.views)  # LookUp goes to the next one
        self._plans: dict[frozenset[int], _Plan] = {}

    def action(self, search: Search) -> Action | None:
        """The best next action.

        Args:
            search: a search of this episode, in any state.

        Returns:
            None where success cannot be reached any more.
        """
        plan, here = self._plan(frozenset(np.flatnonzero(search.opened).tolist())), self._at(search.pose)
        moves, steps = plan.moves[here[:2]], plan.steps[here]
        if moves < 0 or steps >= _NEVER:
            return None
        for ends, action in ((plan.done, Action.DONE), (plan.opening, Action.OPEN)):
            if (ends.moves[here], ends.steps[here]) == (moves, steps):
                return action
        return next(action for action in _ORDER if self._leads(plan, here, action))

    def to_go(self, search: Search) -> tuple[int, int] | None:
        """Moves and steps that are still needed, Done included.

        Args:
            search: a search of this episode, in any state.

        Returns:
            None where success cannot be reached any more.
        """
        plan, here = self._plan(frozenset(np.flatnonzero(search.opened).tolist())), self._at(search.pose)
        moves, steps = plan.moves[here[:2]], plan.steps[here]
        return None if moves < 0 or steps >= _NEVER else (int(moves), int(steps))

    def _leads(self, plan: _Plan, here: _At, action: Action) -> bool:
        """Whether an action leaves one step fewer to go without adding moves."""
        i, j, heading, view = here
        moves, steps = plan.moves[i, j], plan.steps[here] - 1
        if action == Action.MOVE_AHEAD:
            i, j, moves = i + AHEAD[heading][0], j + AHEAD[heading][1], moves - 1
            inside = 0 <= i < plan.moves.shape[0] and 0 <= j < plan.moves.shape[1]
            return bool(inside and plan.moves[i, j] == moves >= 0 and plan.steps[i, j, heading, view] == steps)
        if action in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            heading = (heading + (1 if action == Action.ROTATE_LEFT else 3)) % 4
        else:
            view += 1 if action == Action.LOOK_UP else -1
        return 0 <= view < len(self._views) and bool(plan.steps[i, j, heading, view] == steps)

    def _at(self, pose: Pose) -> _At:
        """Array indices of a pose."""
        return pose.i, pose.j, pose.heading, self._views.index((pose.height, pose.pitch_deg))

    @cached_property
    def _holder(self) -> int:
        """The closed container that the target is in; -1 for none."""
        holder = self._world.arrangement.objects[self._target - self._world.house.n_instances].holder
        return holder if holder >= 0 and self._world.openable[holder] else -1

    @cached_property
    def _near(self) -> frozenset[int]:
        """Containers whose open doors may hide the target."""
        boxes, target = self._world.boxes, self._world.boxes[self._target]
        gaps = np.maximum(np.maximum(boxes[:, :2] - target[3:5], target[:2] - boxes[:, 3:5]), 0.0)  # (n, 2)
        return frozenset(np.flatnonzero(self._world.openable & (np.hypot(*gaps.T) <= _IN_THE_WAY_M)).tolist())

    def _plan(self, opened: frozenset[int]) -> _Plan:
        """The plan for a set of open containers; computed once."""
        matter = opened & (self._near | {self._holder})
        if matter not in self._plans:
            self._plans[matter] = self._compute_plan(matter)
        return self._plans[matter]

    def _compute_plan(self, opened: frozenset[int]) -> _Plan:
        """Distances from all poses at which Done succeeds, or Open opens the target's container."""
        shape = (*self._world.free.shape, 4, len(self._views))
        done = _Ends.none(shape)
        for at in self._successes(opened):
            done.moves[at], done.steps[at] = 0, 1
        opening = _Ends.none(shape)
        if self._holder >= 0 and self._holder not in opened:
            for also, poses in self._openings(opened):
                after = self._plan(opened | also)
                for at in poses:
                    if after.moves[at[:2]] >= 0:
                        opening.moves[at], opening.steps[at] = after.moves[at[:2]], after.steps[at] + 1
        nearest = np.minimum(done.moves, opening.moves).min((2, 3))  # (nx, ny)
        ends = np.argwhere(nearest < _NEVER)
        moves = distances(self._world.free, ends, nearest[tuple(ends.T)])
        nodes = np.argwhere(moves >= 0)
        order: I32 = nodes[np.argsort(moves[tuple(nodes.T)], kind="stable")].astype(np.int32)
        here = moves[..., None, None]
        last = np.minimum(
            np.where(done.moves == here, done.steps, _NEVER), np.where(opening.moves == here, opening.steps, _NEVER)
        )
        return _Plan(moves, _fewest_steps(moves, order, last), done, opening)

    def _openings(self, opened: frozenset[int]) -> list[tuple[frozenset[int], list[_At]]]:
        """Sets of containers that one Open opens, the target's among them, with the poses at which it does so."""
        closed = np.array(sorted(set(np.flatnonzero(self._world.openable).tolist()) - opened))
        sets: dict[frozenset[int], list[_At]] = {}
        self._show(opened, 1.0)
        for node in self._solver.near_nodes(self._holder):
            reach = closed[self.rules.near(self._world.house.grid.xy(node), self._world.boxes[closed])]
            for pose in self._opening_poses(node):
                found = reach
                if self.rules.open_needs_sight:
                    found = reach[self._solver.counts(pose)[reach] >= self.rules.open_min_pixels]
                also = frozenset(found.tolist()) & (self._near | {self._holder})
                if self._holder in also:
                    sets.setdefault(also, []).append(self._at(pose))
        self._show(opened, 0.0)
        return sorted(sets.items(), key=lambda item: (len(item[0]), -len(item[1]), sorted(item[0])))[:MAX_OPEN_SETS]

    def _opening_poses(self, node: tuple[int, int]) -> Iterator[Pose]:
        """Poses at a node from which Open may work on the target's container: all, where Open needs no sight."""
        if self.rules.open_needs_sight:
            yield from self._solver.facing(node, self._holder)
        else:
            yield from (Pose(*node, heading, *view) for heading in range(4) for view in self._views)

    def _successes(self, opened: frozenset[int]) -> list[_At]:
        """Every pose where Done succeeds with these containers open."""
        self._show(opened, 1.0)
        poses = (p for node in self._solver.near_nodes(self._target) for p in self._solver.facing(node, self._target))
        found = [self._at(p) for p in poses if self._solver.counts(p)[self._target] >= self.rules.done_min_pixels]
        self._show(opened, 0.0)
        return found

    def _show(self, opened: frozenset[int], fraction: float) -> None:
        """Show containers open (1.0) or closed (0.0)."""
        for instance in sorted(opened):
            self._eyes.set_open(instance, fraction)


@jit
def _fewest_steps(moves: I32, order: I32, last: I32) -> I32:
    """Steps from every pose along paths with the fewest moves.

    Args:
        moves: (nx, ny) int32, fewest moves, -1 for none.
        order: (n, 2) int32, the nodes with a path, sorted by ``moves``.
        last: (nx, ny, 4, V) int32, steps still needed at poses where a path may end.

    Returns:
        (nx, ny, 4, V) int32.
    """
    nx, ny, _, n_views = last.shape
    steps = last.copy()
    for k in range(len(order)):
        i, j = order[k]
        for heading in range(4):
            a = i + (heading == 0) - (heading == 2)
            b = j + (heading == 1) - (heading == 3)
            if 0 <= a < nx and 0 <= b < ny and moves[a, b] >= 0 and moves[a, b] == moves[i, j] - 1:
                for view in range(n_views):
                    steps[i, j, heading, view] = min(steps[i, j, heading, view], steps[a, b, heading, view] + 1)
        changed = True
        while changed:  # rotations and looks at the node
            changed = False
            for heading in range(4):
                for view in range(n_views):
                    best = min(steps[i, j, (heading + 1) % 4, view], steps[i, j, (heading + 3) % 4, view])
                    if view > 0:
                        best = min(best, steps[i, j, heading, view - 1])
                    if view + 1 < n_views:
                        best = min(best, steps[i, j, heading, view + 1])
                    if best + 1 < steps[i, j, heading, view]:
                        steps[i, j, heading, view] = best + 1
                        changed = True
    return steps
