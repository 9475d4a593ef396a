"""Draws the start of an episode, with its shortest path and a solution from there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from ucon.scenes.spec import GRID_M
from ucon.sim.state import SceneState
from ucon.task.episode import Start
from ucon.task.robot.pose import start_pose
from ucon.task.robot.rig import RobotRig, floor_of
from ucon.task.robot.solve import RobotSolver
from ucon.task.rules import TaskRules
from ucon.task.search import Eyes, Pose
from ucon.task.solve import Solution, Solver

#: Least path length from the start to success, where the home allows it, metres.
MIN_START_M: Final = 2.0
#: Starts that are tried for each least path length.
_TRIES: Final = 4
_ROBOT_TRIES: Final = 8


@dataclass(frozen=True)
class SolvedStart:
    """A start from which the target can be found."""

    start: Start
    shortest_path_m: float
    solution: Solution


def drawn_start(
    world: SceneState, eyes: Eyes, target: int, rules: TaskRules, rng: np.random.Generator
) -> SolvedStart | None:
    """A random start, if possible at least 2 m of path from success; None where there is no solution.

    Args:
        world: the home and what was placed in it.
        eyes: a renderer with this world loaded that counts pixels in the rules' view.
        target: instance of the target.
        rules: the rule set.
        rng: draws the start.
    """
    if rules.continuous:
        return _robot_start(world, eyes, target, rules, rng)
    solver = Solver(world, eyes, target, rules)
    if not solver.solvable:
        return None
    moves = solver.field()
    for least_m in (MIN_START_M, GRID_M):
        nodes = np.argwhere(moves * GRID_M >= least_m)
        for pick in rng.permutation(len(nodes))[:_TRIES]:
            i, j = (int(v) for v in nodes[pick])
            start = Start(i, j, int(rng.integers(4)))
            solution = solver.solve(Pose(i, j, start.heading, rules.start_height, 0))
            if solution is not None and solution.moves and len(solution.actions) <= rules.max_steps:
                return SolvedStart(start, solution.path_m, solution)
    return None


def _robot_start(
    world: SceneState, eyes: Eyes, target: int, rules: TaskRules, rng: np.random.Generator
) -> SolvedStart | None:
    """Like :func:`drawn_start`, for a robot that moves continuously; it starts on a node of the grid."""
    solver = RobotSolver(world, eyes, target, rules, floor_of(world, RobotRig.exact()))
    if not solver.findable:
        return None
    nodes = np.argwhere(world.free)
    for least_m in (MIN_START_M, GRID_M):
        for pick in rng.permutation(len(nodes))[:_ROBOT_TRIES]:
            i, j = (int(v) for v in nodes[pick])
            start = Start(i, j, int(rng.integers(4)))
            found = solver.solve(start_pose(world.house, start))
            if found is None or found[0] < least_m:
                continue
            if found[1].moves and len(found[1].actions) <= rules.max_steps:
                return SolvedStart(start, *found)
    return None
