"""Distances of views from the episode's goal: a privileged label for training, never shown to an agent."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ucon.envs.frame import StartFrame
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.mapping.semantic_map import HALF, View
from ucon.sim.paths import UNREACHABLE, distances
from ucon.task.ledger import solution_nodes


class DistanceToGoal:
    """Moves from any view to where Done succeeds, in the episode that an environment plays."""

    def __init__(self, env: UcONEnv) -> None:
        """Compute the distances of all nodes.

        Args:
            env: the environment, after its reset.
        """
        self._frame = StartFrame(env.episode.start)
        _, end = solution_nodes(env.episode)
        self._field = distances(env.search.world.free, [end])

    def __call__(self, views: Sequence[View]) -> NDArray[np.float32]:
        """Moves from each view to the last node of the stored solution, on the true floor.

        Args:
            views: n views on the agent's map.

        Returns:
            (n,) float32; -1 where there is no path.
        """
        ahead, left = np.array([(view.i - HALF, view.j - HALF) for view in views], np.int64).reshape(-1, 2).T
        i, j = self._frame.nodes(ahead, left)
        there = (i >= 0) & (i < self._field.shape[0]) & (j >= 0) & (j < self._field.shape[1])
        out = np.full(len(views), UNREACHABLE, np.float32)
        out[there] = self._field[i[there], j[there]]
        return out
