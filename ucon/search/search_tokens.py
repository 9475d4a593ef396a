"""A search decision as arrays, the input of the habit policy: tokens of views, things and frontiers, and the state.

Positions are relative to the agent's position and heading. Only what the agent itself knows goes in: its map, the
expected mass by the habits it was given, and gains and costs of views.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.semantic_map import CELL_M
from ucon.perception.places.affordances import affordance, sight_range_m
from ucon.perception.places.place_kernels import INSIDE
from ucon.perception.views.candidates import frontiers
from ucon.perception.views.pick_kernels import picked_views
from ucon.perception.views.view_kernels import PITCHES_DEG
from ucon.perception.views.viewpoints import Choice, ViewValues
from ucon.search.map_raster import map_raster
from ucon.search.search_decision import SearchDecision
from ucon.search.searcher import Searcher
from ucon.search.text_tokens import category_rows
from ucon.search.view_tokens import N_VIEW, ViewSurroundings, log_scale, to_agent_frame, view_rows

F32 = NDArray[np.float32]
THING_KINDS: Final = ("fixed_furniture", "movable_furniture", "fixture", "wall", "ceiling", "movable", "structure")
#: Columns of a thing token.
N_THING: Final = 14 + len(THING_KINDS)
#: Columns of a thing's position ahead and to the left, in units of 5 m.
THING_AHEAD: Final = slice(4, 6)
#: Columns of a frontier token.
N_FRONTIER: Final = 6
#: Length of the state vector.
N_EGO: Final = 18 + len(PITCHES_DEG)


@dataclass(frozen=True)
class Sizes:
    """Rows of each kind of token.

    Attributes:
        views: V, the views that are candidates.
        things: T, the things with most mass.
        frontiers: F, the cheapest frontiers.
    """

    views: int = 32
    things: int = 32
    frontiers: int = 12


@dataclass(frozen=True, eq=False)
class Tokens(Shared):
    """The arrays of one decision.

    Attributes:
        arrays: see below; unused rows are zero.
        choices: the choice behind each row of ``views`` whose mask is 1.

    Keys of ``arrays``:

    - ``views`` (V, N_VIEW), ``things`` (T, N_THING), ``frontiers`` (F, N_FRONTIER), ``ego`` (N_EGO,): float32.
    - ``thing_rows`` (T,) int32: rows of the things in the catalogue, -1 for none.
    - ``prior`` (V,) float32: logarithm of each view's gain over cost.
    - ``map`` (C, 41, 41) uint8: see :mod:`ucon.search.map_raster`.
    - ``action_mask`` (V,), ``things_mask`` (T,), ``frontiers_mask`` (F,): int8, 1 for rows in use.
    """

    arrays: Mapping[str, NDArray[Any]]
    choices: tuple[Choice, ...]


class TokenReader(PartlyShared):
    """Turns the decisions of one search into arrays."""

    _shared: ClassVar[frozenset[str]] = frozenset({"sizes", "_fixed"})

    def __init__(self, searcher: Searcher, info: Mapping[str, Any], sizes: Sizes | None = None) -> None:
        """Start an episode.

        Args:
            searcher: the search.
            info: the info at the reset.
            sizes: rows of each kind of token; defaults where None.
        """
        self._searcher, self.sizes = searcher, sizes or Sizes()
        book, target = catalogue(), searcher.target
        size = sorted(book[target].size) if target in book else [0.1, 0.1, 0.1]
        self._fixed = [np.log10(side) for side in size]
        self._fixed += [sight_range_m(target) / 4.5, len(info["habits"]) / 500.0]
        self._fixed.append(float(info.get("habit_level") == "gt"))

    def read(self, decision: SearchDecision) -> Tokens:
        """The arrays of a decision that is due.

        Where no view has any gain, ``views`` has one row (or none, where there is nowhere to go).
        """
        known, places, sizes = self._searcher.map, self._searcher.places, self.sizes
        seen = self.read_views(decision)
        weight, mass = places.weights(decision.expected.mass), places.remaining_mass(decision.expected.mass)
        things, numbers = self._things(mass)
        edges = self._frontiers(decision)
        arrays: dict[str, NDArray[Any]] = {
            **seen.arrays,
            "things": _padded(things, sizes.things, N_THING),
            "thing_rows": np.append(numbers, np.full(sizes.things - len(numbers), -1)).astype(np.int32),
            "things_mask": _mask(len(things), sizes.things),
            "frontiers": _padded(edges, sizes.frontiers, N_FRONTIER),
            "frontiers_mask": _mask(len(edges), sizes.frontiers),
            "ego": self._ego(decision, mass),
            "map": map_raster(known, self._searcher.viewpoints, places.xyz, weight, decision.expected.interest),
        }
        return Tokens(arrays, seen.choices)

    def read_views(self, decision: SearchDecision) -> Tokens:
        """Only the arrays of a decision that describe its views: choosing by gain over cost needs no others."""
        rows, prior, choices = self._views(decision, self._searcher.places.weights(decision.expected.mass))
        arrays: dict[str, NDArray[Any]] = {
            "views": _padded(rows, self.sizes.views, N_VIEW),
            "prior": _padded(prior[:, None], self.sizes.views, 1)[:, 0],
            "action_mask": _mask(len(choices), self.sizes.views),
        }
        return Tokens(arrays, choices)

    def _views(self, decision: SearchDecision, weight: NDArray[np.float64]) -> tuple[F32, F32, tuple[Choice, ...]]:
        """The selected n views: rows (n, N_VIEW), log of gain over cost (n,), choices."""
        valued, known = decision.valued, self._searcher.map
        if valued is None:
            only = () if decision.best is None else (decision.best,)
            blank = np.zeros(len(only), np.float32)
            return np.zeros((len(only), N_VIEW), np.float32), blank, only
        at = self._picked(valued)
        choices = tuple(valued.at(*view) for view in zip(*(k.tolist() for k in at), strict=True))
        score = np.array([choice.score for choice in choices])
        prior = np.log(np.maximum(score, 1e-12)).astype(np.float32)
        around = ViewSurroundings(known, self._searcher.places.xyz, weight)
        return view_rows(valued, at, choices, known, around), prior, choices

    def _picked(self, valued: ViewValues) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Node, heading and pitch numbers (n,) of the selected views. The current pose is left out."""
        pitch = valued.score.argmax(2)[..., None]
        score = np.take_along_axis(valued.score, pitch, 2)[..., 0]
        gain = np.take_along_axis(valued.looks + valued.opens, pitch, 2)[..., 0]
        n, h, p = valued.kept_at
        if n >= 0:
            pitch[n, h, 0] = p
        here = self._searcher.map.view
        if here.pitch_deg in PITCHES_DEG:
            stands = (valued.nodes[:, 0] == here.i) & (valued.nodes[:, 1] == here.j)
            score[stands, here.heading] *= pitch[stands, here.heading, 0] != PITCHES_DEG.index(here.pitch_deg)
        headings = score.shape[1]
        picked = picked_views(valued.nodes, score, gain, self.sizes.views, headings * n + h if n >= 0 else -1)
        node, heading = np.divmod(picked, headings)
        return node, heading, pitch[node, heading, 0]

    def _things(self, mass: NDArray[np.float64]) -> tuple[F32, NDArray[np.int64]]:
        """Rows (n, N_THING) of the things with most mass (T, 4) left, and their rows in the catalogue (n,)."""
        known, places = self._searcher.map, self._searcher.places
        total = mass.sum(1)
        tracks = np.argsort(-total, kind="stable")[: self.sizes.things]
        tracks = tracks[total[tracks] > 1e-9]
        box, shut = known.box[tracks], np.zeros(known.n_tracks, bool)
        shut[self._searcher.openable_now()] = True
        rows = np.zeros((len(tracks), N_THING), np.float32)
        rows[:, :4] = log_scale(mass[tracks])
        xy = 0.5 * (box[:, :2] + box[:, 3:5])
        rows[:, THING_AHEAD] = to_agent_frame(xy - np.array(known.view.xy), known.view) / 5.0
        rows[:, 6] = 0.5 * (box[:, 2] + box[:, 5])
        rows[:, 7:10] = box[:, 3:] - box[:, :3]
        rows[:, 10], rows[:, 11] = shut[tracks], known.opened[tracks]
        rows[:, 12] = known.pixels[tracks] > 0
        rows[:, 13] = places.unseen_share(known.n_tracks)[tracks]
        names = [known.category[track] for track in tracks]
        rows[
            np.arange(len(names)), 14 + np.array([THING_KINDS.index(affordance(name).kind) for name in names], int)
        ] = 1.0
        return rows, np.array([category_rows().get(name, -1) for name in names], np.int64)

    def _frontiers(self, decision: SearchDecision) -> F32:
        """Rows (n, N_FRONTIER) of the cheapest frontiers."""
        known, planner = self._searcher.map, self._searcher.planner
        found = frontiers(known, planner)[: self.sizes.frontiers]
        interest = decision.expected.interest
        rows = np.zeros((len(found), N_FRONTIER), np.float32)
        for row, edge in zip(rows, found, strict=True):
            xy = np.array(edge.view.xy) - np.array(known.view.xy)
            row[:2] = to_agent_frame(xy[None], known.view)[0] / 5.0
            row[2], row[3] = np.sqrt(edge.cost / 40.0), np.log10(edge.cells)
            row[4] = 1.0 if interest is None else interest[edge.view.i, edge.view.j]
            row[5] = np.hypot(*edge.view.xy) / 5.0
        return rows

    def _ego(self, decision: SearchDecision, mass: NDArray[np.float64]) -> F32:
        """The state vector (N_EGO,): target, habits, step, explored area, remaining mass, best score, current pitch."""
        known, expected, best = self._searcher.map, decision.expected, decision.best
        shut = self._searcher.openable_now()
        area = float(np.count_nonzero(known.floor)) * CELL_M**2
        left_m2 = max(25.0, 130.0 - area)
        chosen = (0.0, 0.0) if best is None else (log_scale(best.score), log_scale(best.gain))
        left = (mass.sum(), mass[shut, INSIDE].sum(), mass.max(initial=0.0), expected.unknown_per_m2 * left_m2)
        out = [
            *self._fixed, known.step / 300.0, np.sqrt(known.step / 300.0), area / 100.0, known.n_tracks / 100.0,
            *map(log_scale, left), len(shut) / 20.0, *chosen, float(decision.valued is None),
        ]  # fmt: skip
        turned = [float(known.view.pitch_deg == pitch) for pitch in PITCHES_DEG]
        return np.array([*out, *turned], np.float32)


def _padded(rows: NDArray[Any], most: int, width: int) -> F32:
    """The rows with zeros below, (most, width) float32."""
    out = np.zeros((most, width), np.float32)
    out[: len(rows)] = rows
    return out


def _mask(n: int, most: int) -> NDArray[np.int8]:
    """(most,) int8, 1 in the first n entries."""
    return (np.arange(most) < n).astype(np.int8)
