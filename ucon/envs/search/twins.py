"""Twins of an episode: the same search for a target that is elsewhere. Privileged, for trainers.

Until a search sees its target, it does not depend on where the target is. So a single search with a hidden target shows
for every place in the home when a target there would have been found, and with what SPL. The sum of these SPLs,
weighted with the belief over the true home, is the expected SPL of the search. On average it equals the SPL of the
episodes, without the luck of where their targets are: differences between two searches have a variance 10 to 20 times
smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.jit import F32, F64, U8, Flags, jit
from ucon.core.sharing import PartlyShared
from ucon.envs.ucon_env import UcONEnv
from ucon.perception.belief.protocol import Expecting
from ucon.perception.detectors.gt import GtDetector
from ucon.perception.mapping.map_kernels import look
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View, camera_of
from ucon.perception.places.chance_kernels import look_by_chance
from ucon.perception.places.place_kernels import INSIDE
from ucon.perception.places.sight import Sight
from ucon.perception.places.target_places import Places
from ucon.perception.views.view_kernels import sight
from ucon.sim.paths import UNREACHABLE, distances
from ucon.task.search import Pose

#: Actions from the first sight of a target to Done that are not moves: turns, looks, Done. A judgement.
_TURNS: Final = 5
#: Places with a smaller share of the mass are left out.
_LEAST: Final = 1e-5
#: A target that would have been missed with less than this probability counts as found.
_SURE: Final = 1e-3


class Twins(PartlyShared):
    """Places where the target of one episode might be, and how surely the search would have found it at each so far."""

    _shared: ClassVar[frozenset[str]] = frozenset(
        {"p", "shortest", "_xyz", "_hollow", "_faces", "_behind", "_instance", "_number", "_fields", "_frame"}
    )

    def __init__(self, env: UcONEnv, believing: Callable[[], Expecting], height_m: float, reach_m: float) -> None:
        """Map the true home, and find out where in it the target may be.

        Args:
            env: the environment, after its reset.
            believing: makes the belief about the target in a known home.
            height_m: height of the target.
            reach_m: from how far away the target is recognised, metres of optical depth.

        Raises:
            ConfigError: the rules have no grid.
        """
        env.rules.require_grid("twins of an episode need path lengths on the grid")
        self._reach_m, self._max_steps = reach_m, env.rules.max_steps
        known, frames, instance = _toured(env)
        places = Places(height_m)
        places.refresh(known)
        weight = places.weights(believing().expect(known, places).mass)
        of, openable = instance[places.track], env.search.world.openable
        # A place that is visible from nowhere is left out; places behind doors are visible once these are open.
        behind = (places.relation == INSIDE) & openable[of]
        hidden = np.ones(len(weight))
        for view, depth in frames:
            args = (places.xyz, places.hollow, places.faces, (hidden > 0) & ~behind & (weight > 0))
            look(depth, camera_of(view, depth, known.body), reach_m, *args, hidden, 0.0)
        there = np.flatnonzero((weight > _LEAST * weight.sum()) & (behind | (hidden == 0)))
        self._xyz, self._hollow = places.xyz[there].copy(), places.hollow[there].copy()
        self._faces, self._behind, self._instance = places.faces[there], behind[there], of[there]
        self._fields, self._number = _ways(env, known, self._xyz)
        start, self._frame = env.episode.start, env.tour.frame
        #: (n,) moves of a shortest path from the start to each place
        self.shortest = self._fields[self._number, start.i, start.j]
        p = np.where(self.shortest == UNREACHABLE, 0.0, weight[there])
        #: (n,) probability that the target is at each place
        self.p = p / max(float(p.sum()), 1e-12)
        #: (n,) probability that a target at each place would not have been found so far
        self.unseen = np.ones(len(there))
        self._looked = np.zeros(len(there), np.uint64)

    @property
    def left(self) -> float:
        """Probability that the target would not have been found so far."""
        return float(self.p @ self.unseen)

    def within(self, views: Sequence[View], moves: Sequence[int]) -> NDArray[np.float32]:
        """Share of the targets not found yet that could be found within some numbers of moves from each of V views.

        Args:
            views: poses of the agent.
            moves: R limits on the number of moves.

        Returns:
            (V, R) float32, from 0 to 1.
        """
        left = np.bincount(self._number, self.p * self.unseen, len(self._fields))
        i, j = self._frame.nodes(*np.array([(view.i - HALF, view.j - HALF) for view in views], np.int64).T)
        ways = self._fields[:, i, j]  # (fields, V)
        found = np.stack([left @ (ways <= limit) for limit in moves], 1)
        return np.asarray(found / max(float(left.sum()), 1e-12), np.float32)

    def see(
        self, env: UcONEnv, known: SemanticMap, depth: NDArray[np.float32], moves: int, steps: int, by: Sight | None
    ) -> float:
        """Take in the newest frame.

        Args:
            env: the environment.
            known: the agent's map, updated with the frame.
            depth: (H, W) float32, metres along the optical axis.
            moves: moves of the search so far.
            steps: steps of the search so far.
            by: chances that a look shows the target, for a detector that errs; None: for one that does not.

        Returns:
            Expected SPL of the targets that this frame shows for the first time.
        """
        opened = self._behind & env.search.opened[self._instance]
        before, camera = self.unseen.copy(), camera_of(known.view, depth, known.body)
        active, points = (self.unseen > _SURE) & ~self._behind, (self._xyz, self._hollow, self._faces)
        if by is None:
            self.unseen[opened] = 0.0  # opening a door includes a look inside
            look(depth, camera, self._reach_m, *points, active, self.unseen, 0.0)
        else:
            look_by_chance(depth, camera, by.model, *points, active | opened, self.unseen, self._looked)
        new = np.flatnonzero(self.unseen < before)
        if not len(new):
            return 0.0
        pose: Pose = env.search.pose
        rest = self._fields[self._number[new], pose.i, pose.j]
        in_time = (rest != UNREACHABLE) & (steps + rest + _TURNS <= self._max_steps)
        spl = self.shortest[new] / np.maximum(np.maximum(self.shortest[new], moves + rest), 1)
        spl[self.shortest[new] == 0] = 1.0
        return float((self.p[new] * (before - self.unseen)[new]) @ (spl * in_time))


def _toured(env: UcONEnv) -> tuple[SemanticMap, list[tuple[View, NDArray[np.float32]]], NDArray[np.int64]]:
    """A map of the whole home with true names, the frames that it was made from, and the instance of each track."""
    detector = GtDetector()
    detector.reset(env.episode.id, env.search.world.categories)
    known = SemanticMap.of({"task": env.rules.name, "target": env.episode.target_category})
    frames = []
    for observation, info in replace(env.tour, detector=detector)():
        known.update(observation, info)
        frames.append((known.view, info["depth"]))
    known.tour(())
    known.views.append(View(HALF, HALF, 0))
    instance = np.full(known.n_tracks, -1, np.int64)
    for number in range(len(env.search.world.boxes)):
        for track in detector.tracks_of((number,)):
            instance[track] = number
    return known, frames, instance


def _ways(env: UcONEnv, known: SemanticMap, xyz: NDArray[np.float64]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Moves from every node to where Done would succeed for a target at each of n places.

    Returns:
        One field for each of the k cells that hold places, (k, nx, ny), and the number of each place's field, (n,).
    """
    free = np.ascontiguousarray(env.search.world.free)
    cells = np.floor(xyz[:, :2] / CELL_M + 0.5).astype(np.int64)
    _, first, number = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    reach = int(env.rules.near_m / CELL_M) + 1
    a, b = (k.ravel() for k in np.meshgrid(*[np.arange(-reach, reach + 1)] * 2, indexing="ij"))
    fields = np.full((len(first), *free.shape), UNREACHABLE, np.int32)
    for k, row in enumerate(first.tolist()):
        ahead, left = cells[row, 0] + a, cells[row, 1] + b
        near = np.hypot(ahead * CELL_M - xyz[row, 0], left * CELL_M - xyz[row, 1]) <= env.rules.near_m
        ahead, left = ahead[near], left[near]
        i, j = env.tour.frame.nodes(ahead, left)
        ok = (i >= 0) & (j >= 0) & (i < free.shape[0]) & (j < free.shape[1])
        ok[ok] = free[i[ok], j[ok]]
        seen = np.zeros(len(ahead), bool)
        _shown(np.stack([ahead, left], 1), xyz[row], known.body.camera_m, known.height, known.walls, seen)
        good = ok & seen if (ok & seen).any() else ok
        if good.any():
            fields[k] = distances(free, np.stack([i[good], j[good]], 1))
    return fields, number.reshape(-1)


@jit
def _shown(nodes: Any, xyz: F64, cam_z: float, height: F32, walls: U8, out: Flags) -> None:
    """Whether a point is visible from each of n nodes (n, 2) of the start frame; written to ``out`` (n,)."""
    for n in range(nodes.shape[0]):
        x, y = nodes[n, 0] * CELL_M, nodes[n, 1] * CELL_M
        out[n] = sight(x, y, cam_z, xyz[0], xyz[1], xyz[2], height, walls, HALF)
