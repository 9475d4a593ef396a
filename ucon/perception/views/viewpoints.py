"""Choosing where to look next: the expected mass that a view shows, divided by the cost of getting there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import HALF, SIZE, SemanticMap, View
from ucon.perception.places.chance_kernels import fade_by_chance, gain_by_chance
from ucon.perception.places.containers import open_reach_m
from ucon.perception.places.place_kernels import INSIDE
from ucon.perception.places.target_places import Places
from ucon.perception.views import view_kernels as kernels
from ucon.perception.views.space_kernels import fade_space, space_gain

#: Every node within this many cells is considered, and one in four beyond.
FINE_CELLS = 4
#: Places with ``unseen`` up to this are not looked at again until everything else was.
SEEN = 0.15
#: Where the detector errs, views are valued by the places that hold this share of the mass.
VALUED = 0.97


@dataclass(frozen=True, slots=True)
class Expectation(Shared):
    """Where the target may be, in any common unit of mass (probabilities, or the weights of coverage)."""

    mass: NDArray[np.float64]
    """(T, 4) of every track and relation (ontop, inside, under, nextto)."""
    unknown_per_m2: float
    """Of a square metre that was not explored yet."""
    near_per_m2: float
    """Of a square metre that was seen, but from too far away to have shown the target."""
    interest: NDArray[np.float32] | None = None
    """(257, 257) factors of ``unknown_per_m2`` by cell; all 1 where None."""
    unit: float = 1.0
    """Mass of a whole home."""


@dataclass(frozen=True, slots=True)
class Choice(Shared):
    """A view to go to."""

    view: View
    opens: bool
    """Whether to Open on arrival."""
    gain: float
    """Expected mass that the view shows, and that Open shows where ``opens``."""
    score: float
    """Gain over cost."""


@dataclass(frozen=True, slots=True)
class Costs(Shared):
    """The costs in score = gain / (cost + overhead); one MoveAhead costs 1."""

    overhead: float = 0.25
    """Added to every view's cost. On a third of the validation set (134 episodes, SPL at 2.0 / 0.5):
    frontier .458 / .466, belief none .450 / .467, retrieval .447 / .462, gt .450 / .504, and .511 at 0.2; paired
    intervals about 0.04."""
    turn: float = 0.6
    """Of a rotation, LookUp or LookDown."""
    open: float = 0.5
    """Of an Open; like a rotation it adds nothing to the path length."""
    space_cells: int = 22
    """How far from a node unexplored space counts, in cells."""
    space: float = 1.75
    """Factor of the gain of unexplored space, since there is more behind what a view shows. A judgement: between
    factors of 1 and 2.5, SR and SPL on the validation set differ by less than their noise."""
    around: float = 1.0
    """Of each further heading when the agent looks around at a node."""


@dataclass(frozen=True, eq=False)
class ViewValues(Shared):
    """Gains, costs and scores of all views: n nodes, H headings, and the 4 pitches of ``PITCHES_DEG``."""

    nodes: NDArray[np.int32]
    """(n, 2) cells i, j."""
    looks: NDArray[np.float64]
    """(n, H, 4) expected mass that looking shows."""
    space: NDArray[np.float64]
    """(n, H, 4) the part of ``looks`` that is in unexplored space, or in space seen only from far away."""
    opens: NDArray[np.float64]
    """(n, H, 4) expected mass behind the doors that Open opens."""
    steps: NDArray[np.float64]
    """(n, H) actions to the node and heading, without LookUp and LookDown; UNREACHED where there is no path."""
    moves: NDArray[np.int32]
    """(n, H) those of the actions that are MoveAhead."""
    cost: NDArray[np.float64]
    """(n, H, 4) weighted by :class:`Costs`; infinite where there is no path."""
    look_score: NDArray[np.float64]
    """(n, H, 4) gain over cost of looking."""
    both_score: NDArray[np.float64]
    """(n, H, 4) gain over cost of looking and opening."""
    score: NDArray[np.float64]
    """(n, H, 4) the better of the two."""
    kept_at: tuple[int, int, int]
    """Node, heading and pitch numbers of the view that the agent is on its way to; (-1, 0, 0) where there is none."""

    def at(self, n: int, h: int, p: int) -> Choice:
        """The choice of one view; it opens on arrival if that has the higher score.

        Args:
            n: row of the node.
            h: heading.
            p: number of the pitch in ``PITCHES_DEG``.
        """
        view = View(int(self.nodes[n, 0]), int(self.nodes[n, 1]), h, kernels.PITCHES_DEG[p])
        opening = bool(self.opens[n, h, p] > 0 and self.both_score[n, h, p] >= self.look_score[n, h, p])
        gain = self.looks[n, h, p] + (self.opens[n, h, p] if opening else 0.0)
        return Choice(view, opening, float(gain), float(self.score[n, h, p]))

    @property
    def best(self) -> Choice:
        """The choice with the highest score."""
        n, h, p = np.unravel_index(int(self.score.argmax()), self.score.shape)
        return self.at(int(n), int(h), int(p))

    @property
    def kept(self) -> Choice | None:
        """The choice of the view that the agent is on its way to, with its current score; None where there is none."""
        return self.at(*self.kept_at) if self.kept_at[0] >= 0 else None


class Viewpoints(PartlyShared):
    """Values views on the map of one episode.

    Attributes:
        reach_m: from how far away the target would be recognised, metres.
        costs: of moves, rotations and looks.
        stale: (257, 257) float32 factors of the area that views show; lowered where a view showed nothing new.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_even"})

    def __init__(self, reach_m: float, costs: Costs | None = None) -> None:
        """Start an episode.

        Args:
            reach_m: from how far away the target would be recognised, metres.
            costs: of moves, rotations and looks; defaults where None.
        """
        self.reach_m = reach_m
        self.costs = costs or Costs()
        self.stale = np.ones((SIZE, SIZE), np.float32)
        self._even = np.ones((SIZE, SIZE), np.float32)
        self._index = np.full((SIZE, SIZE), -1, np.int32)

    def choose(
        self,
        known: SemanticMap,
        planner: Planner,
        places: Places,
        expected: Expectation,
        closed: NDArray[np.int64],
        keep: View | None = None,
    ) -> tuple[Choice | None, Choice | None]:
        """The view with the highest gain over cost.

        Args:
            known: the map.
            planner: paths from the current pose; must be up to date.
            places: sample points of the map.
            expected: mass of tracks, relations and space.
            closed: (c,) int64, tracks of closed containers.
            keep: the view that the agent is on its way to.

        Returns:
            The best choice, and that of ``keep`` with its current score; None for each where there is none.
        """
        found = self.value(known, planner, places, expected, closed, keep)
        return (None, None) if found is None else (found.best, found.kept)

    def value(
        self,
        known: SemanticMap,
        planner: Planner,
        places: Places,
        expected: Expectation,
        closed: NDArray[np.int64],
        keep: View | None = None,
    ) -> ViewValues | None:
        """Gains, costs and scores of all views.

        Args:
            known: the map.
            planner: paths from the current pose; must be up to date.
            places: sample points of the map.
            expected: mass of tracks, relations and space.
            closed: (c,) int64, tracks of closed containers.
            keep: the view that the agent is on its way to; its node is always among those valued.

        Returns:
            None where no node can be reached.
        """
        nodes = self._nodes(known, planner, keep)
        if not len(nodes):
            return None
        looks, space, opens = self._gains(nodes, known, places, expected, closed)
        steps = planner.steps[nodes[:, 0], nodes[:, 1]].astype(float)  # (n, H)
        moves = planner.moves[nodes[:, 0], nodes[:, 1]]
        pitch = np.abs(np.array(kernels.PITCHES_DEG) - known.view.pitch_deg) / 30.0
        cost = moves + self.costs.turn * (steps - moves)
        cost = cost[:, :, None] + self.costs.turn * pitch + self.costs.overhead
        cost[steps >= UNREACHED] = np.inf
        cost[:, :, [p not in known.body.searching for p in kernels.PITCHES_DEG]] = np.inf
        look_score = np.maximum(looks / cost, self._around(looks, cost))
        both_score = (looks + opens) / (cost + self.costs.open)
        score = np.maximum(look_score, np.where(opens > 0, both_score, 0.0))
        kept = (-1, 0, 0)
        if keep is not None and keep.pitch_deg in kernels.PITCHES_DEG and self._index[keep.i, keep.j] >= 0:
            kept = (int(self._index[keep.i, keep.j]), keep.heading, kernels.PITCHES_DEG.index(keep.pitch_deg))
        self._index[nodes[:, 0], nodes[:, 1]] = -1
        return ViewValues(nodes, looks, space, opens, steps, moves, cost, look_score, both_score, score, kept)

    def nearest_unvisited(self, known: SemanticMap, planner: Planner) -> Choice | None:
        """The nearest node that the agent never stood on: a last resort where no view has any gain.

        Returns:
            A choice of gain and score 0; None where no such node can be reached.
        """
        beside = cv2.dilate(known.explored, np.ones((3, 3), np.uint8)) > 0
        steps = np.where(beside[:, :, None] & (known.visited == 0)[:, :, None], planner.steps, UNREACHED)
        i, j, heading = (int(k) for k in np.unravel_index(int(steps.argmin()), steps.shape))
        if steps[i, j, heading] >= UNREACHED:
            return None
        return Choice(View(i, j, heading, known.view.pitch_deg), False, 0.0, 0.0)

    def _around(self, looks: NDArray[np.float64], cost: NDArray[np.float64]) -> NDArray[np.float64]:
        """Score of looking in two and in all headings at the same node and pitch, the better of both; (n, H, 4)."""
        extra = self.costs.around
        two = looks + np.maximum(np.roll(looks, 1, axis=1), np.roll(looks, -1, axis=1))
        all_round = looks.sum(axis=1, keepdims=True)
        return np.maximum(two / (cost + extra), all_round / (cost + (looks.shape[1] - 1.0) * extra))

    def _nodes(self, known: SemanticMap, planner: Planner, keep: View | None) -> NDArray[np.int32]:
        """Reachable explored nodes (n, 2), all of them nearby and every second row and column farther off."""
        i0, i1, j0, j1 = known.extent(0)
        ok = (planner.steps[i0:i1, j0:j1].min(2) < UNREACHED) & (known.explored[i0:i1, j0:j1] > 0)
        here = known.view
        ii, jj = np.nonzero(ok)
        ii, jj = ii + i0, jj + j0
        di, dj = ii - here.i, jj - here.j
        half = ((di | dj) & 1 == 0) | (np.maximum(np.abs(di), np.abs(dj)) <= FINE_CELLS)
        if keep is not None:
            half |= (ii == keep.i) & (jj == keep.j)
        nodes = np.stack([ii[half], jj[half]], 1).astype(np.int32)
        self._index[nodes[:, 0], nodes[:, 1]] = np.arange(len(nodes), dtype=np.int32)
        return nodes

    def _gains(
        self,
        nodes: NDArray[np.int32],
        known: SemanticMap,
        places: Places,
        expected: Expectation,
        closed: NDArray[np.int64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Mass that looking shows, the part of it in space, and the mass that opening shows: three arrays (n, H, 4)."""
        ways = np.zeros((len(nodes), known.body.headings))
        interest = self._even if expected.interest is None else expected.interest
        cells = (known.explored, known.height, known.near, self.stale, interest)
        reach = (self.costs.space_cells, self.reach_m)
        per_m2 = (self.costs.space * expected.unknown_per_m2, expected.near_per_m2)
        space_gain(nodes, cells, reach, per_m2, ways)
        space = ways[:, :, None] * np.array([0.3, 0.95, 1.0, 0.6])
        looks = space.copy()
        opens = np.zeros_like(looks)
        weight = self.weights(places, expected, closed)
        worth = (weight > 1e-9) & (places.unseen > SEEN) if places.sight is None else _most_of(weight)
        rows = np.flatnonzero(worth).astype(np.int32)
        points = (places.xyz, places.hollow, places.faces, weight, places.hidden)
        scene = (known.body.camera_m, known.height, known.walls, HALF)
        if places.sight is None:
            kernels.place_gain(nodes, rows, *points, self.reach_m, *scene, looks)
        else:
            gain_by_chance(nodes, rows, *points, places.looked, places.sight.model, *scene, looks)
        if len(closed):
            inside = expected.mass[closed, INSIDE]
            kernels.open_gain(
                self._index, known.box[closed], known.lived_in, inside, open_reach_m(known), known.body.camera_m,
                known.height, known.walls, HALF, opens,
            )  # fmt: skip
        return looks, space, opens

    def weights(self, places: Places, expected: Expectation, closed: NDArray[np.int64]) -> NDArray[np.float64]:
        """Mass of every sample point that looking alone can show: points inside closed containers have 0.

        Args:
            places: the n sample points.
            expected: mass of tracks and relations.
            closed: (c,) int64, tracks of closed containers.

        Returns:
            (n,) float64.
        """
        weight = places.weights(expected.mass)
        if len(closed):
            shut = np.zeros(len(expected.mass), bool)
            shut[closed] = True
            weight[shut[places.track] & (places.relation == INSIDE)] = 0.0
        return weight

    def lower_expectations(
        self, known: SemanticMap, places: Places, expected: Expectation, closed: NDArray[np.int64], factor: float = 0.3
    ) -> None:
        """Lower the expectations of the current view: what it should have shown by now was not there.

        Call it on arrival at a chosen view. It lowers ``stale`` of cells and ``unseen`` of points.

        Args:
            known: the map.
            places: sample points; ``unseen`` is updated.
            expected: mass of tracks and relations.
            closed: (c,) int64, tracks of closed containers.
            factor: multiplies both.
        """
        view = known.view
        x, y = view.node_xy  # views are valued from their nodes
        cells = (known.explored, known.height, known.near, self.stale, self._even)
        looks, reach = (view.heading, known.body.headings), (self.costs.space_cells, self.reach_m)
        fade_space(view.i, view.j, looks, cells, reach, factor)
        if view.pitch_deg not in {*kernels.PITCHES_DEG} & {*known.body.searching} or not len(places.xyz):
            return
        at = (*looks, kernels.PITCHES_DEG.index(view.pitch_deg))
        weight = self.weights(places, expected, closed)
        if places.sight is not None:
            fade_by_chance(
                x, y, known.body.camera_m, at, places.xyz, places.hollow, places.faces, weight,
                places.sight.model, known.height, known.walls, HALF, places.unseen, places.looked, factor,
            )  # fmt: skip
            return
        kernels.fade_places(
            x, y, known.body.camera_m, at, places.xyz, places.hollow, places.faces, weight,
            self.reach_m, known.height, known.walls, HALF, places.unseen, factor,
        )  # fmt: skip


def _most_of(weight: NDArray[np.float64]) -> NDArray[np.bool_]:
    """The fewest sample points (n,) bool that hold ``VALUED`` of the mass."""
    order = np.argsort(-weight, kind="stable")
    held = np.cumsum(weight[order])
    out = np.zeros(len(weight), bool)
    out[order[: int(np.searchsorted(held, VALUED * held[-1])) + 1] if len(held) else order] = True
    return out & (weight > 0.0)
