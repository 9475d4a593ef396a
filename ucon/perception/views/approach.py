"""Walking up to a thing that was seen: where to stand, which way to look, when Done would succeed."""

from __future__ import annotations

from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.compass import heading_to
from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.body import Body
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View
from ucon.perception.places.affordances import affordance
from ucon.perception.views.approach_kernels import best_views

#: Reach in metres for things near an opened drawer: they are seen where the drawer took them, but count where they were
#: put, farther back.
DRAWER_NEAR_M = 0.55
#: Least reach in metres for things whose box is too large.
LEAST_NEAR_M = 0.5
#: Share of its longer side by which the box of a thing may be too wide, where the detector errs.
LOOSE = 0.1


class Approach(PartlyShared):
    """Finds poses from which a track is visible and within reach, and remembers poses that did not work."""

    _flat: ClassVar[frozenset[str]] = frozenset({"_failed"})

    def __init__(self) -> None:
        self._failed: dict[View, int] = {}
        self._best = (0.0, 1.0)

    def arrived(self, known: SemanticMap, track: int) -> bool:
        """Whether Done would succeed for a track now, as far as the map can tell: in view and within reach."""
        return bool(known.pixels[track] >= MIN_PIXELS) and self.near(known, track)

    def near(self, known: SemanticMap, track: int) -> bool:
        """Whether a track is within the reach of Done, as far as the map can tell."""
        return known.gap_now_m(track) <= float(_reach_m(known, np.array([track]))[0])

    def failed(self, view: View) -> None:
        """Remember that the thing was not visible from a pose; the pose costs more from then on."""
        self._failed[view] = self._failed.get(view, 0) + 1

    def goal(self, known: SemanticMap, planner: Planner, track: int) -> View | None:
        """The cheapest pose from which a track should be visible and within reach.

        Args:
            known: the map.
            planner: paths from the current pose; must be up to date.
            track: the thing.

        Returns:
            A pose on an explored node; None where there is none.
        """
        poses, costs = self.goals(known, planner, np.array([track]))
        return View(*poses[0].tolist()) if costs[0] < UNREACHED else None

    def goals(
        self, known: SemanticMap, planner: Planner, tracks: NDArray[np.int64]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """:meth:`goal` of m tracks at once.

        The cost of a pose is the number of actions to get there, plus penalties where the thing may be hidden or too
        small, or where the pose failed before.

        Args:
            known: the map.
            planner: paths from the current pose; must be up to date.
            tracks: (m,) track numbers.

        Returns:
            Poses (m, 4) int32 as the fields of ``View``, and costs (m,) int32, UNREACHED where there is no pose.
        """
        seen = self._sights(known, tracks)
        return self._poses(known, planner, known.box[tracks], _reach_m(known, tracks) - known.body.off_node_m, seen)

    def _poses(
        self, known: SemanticMap, planner: Planner, boxes: NDArray[np.float64], reach_m: NDArray[np.float64],
        seen: NDArray[np.float64],
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:  # fmt: skip
        """See :func:`ucon.perception.views.approach_kernels.best_views`."""
        cells = (planner.steps, known.height, known.walls, HALF)
        eyes, look = _eyes(known.body), known.view.pitch_deg
        failed = np.array([(v.i, v.j, v.heading, v.pitch_deg, n) for v, n in self._failed.items()], np.int32)
        poses, costs = np.zeros((len(boxes), 4), np.int32), np.full(len(boxes), UNREACHED, np.int32)
        best_views(
            boxes, reach_m, cells, known.explored, eyes, look, seen, failed.reshape(-1, 5), poses, costs
        )  # fmt: skip
        poses[:, 3] = eyes[poses[:, 3], 3]
        return poses, costs

    def pose_at(self, known: SemanticMap, planner: Planner, box: NDArray[np.float64], reach_m: float) -> View | None:
        """The cheapest pose from which a place should be visible and within reach.

        Args:
            known: the map.
            planner: paths from the current pose; must be up to date.
            box: (6,) metres.
            reach_m: horizontal distance that is near enough.

        Returns:
            A pose on an explored node; None where there is none.
        """
        poses, costs = self._poses(known, planner, box[None], np.array([reach_m]), np.array([self._best]))
        return View(*poses[0].tolist()) if costs[0] < UNREACHED else None

    def nearer(self, known: SemanticMap, planner: Planner, track: int) -> View:
        """The explored, reachable node nearest to what was seen of a thing, facing it: more of it shows from there.

        For things of which only a far corner was seen, with no explored node within reach of it.
        """
        i0, i1, j0, j1 = known.extent(0)
        window = (slice(i0, i1), slice(j0, j1))
        ok = (planner.steps[window].min(2) < UNREACHED) & (known.explored[window] > 0)
        nodes = np.argwhere(ok) + np.array([i0, j0])
        xy = (nodes - HALF) * CELL_M
        box = known.box[track]
        gap = np.maximum(np.maximum(box[:2] - xy, xy - box[3:5]), 0.0)
        away = np.hypot(gap[:, 0], gap[:, 1])
        steps = planner.steps[nodes[:, 0], nodes[:, 1]].min(1)
        for view, times in self._failed.items():  # a node that did not help counts as a metre farther
            away[(nodes[:, 0] == view.i) & (nodes[:, 1] == view.j)] += times
        k = int(np.lexsort((steps, np.round(away, 3)))[0])
        dx, dy = (_center(box)[:2] - xy[k]).tolist()
        heading = heading_to(dx, dy, known.body.headings)
        return View(int(nodes[k, 0]), int(nodes[k, 1]), heading)

    def _sights(self, known: SemanticMap, tracks: NDArray[np.int64]) -> NDArray[np.float64]:
        """(m, 2) pixels and distance in metres of the best sight so far; predicts the pixels from a nearer view."""
        out = np.empty((len(tracks), 2))
        out[:] = self._best
        for k in np.flatnonzero(known.pixels[tracks] > self._best[0]).tolist():
            pixels = float(known.pixels[tracks[k]])
            if pixels > self._best[0]:
                gap = _center(known.box[tracks[k]]) - (*known.view.xy, known.body.eyes[known.view.pitch_deg][0])
                self._best = (pixels, float(np.linalg.norm(gap)))
                out[k:] = self._best
        return out


def _reach_m(known: SemanticMap, tracks: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) how near the box of each track must be, metres: less for things that may have come out with a drawer."""
    box = known.box[tracks]
    x, y = 0.5 * (box[:, 0] + box[:, 3]), 0.5 * (box[:, 1] + box[:, 4])
    out = np.full(len(tracks), known.body.near_m - 0.005)
    if known.inexact:
        out = np.maximum(out - _excess_m(known, tracks), LEAST_NEAR_M)
    for holder in np.flatnonzero(known.opened[: known.n_tracks]).tolist():
        if affordance(known.category[holder]).drawers:
            x0, y0, _, x1, y1, z1 = known.box[holder]
            gap = np.hypot(np.maximum(np.maximum(x0 - x, x - x1), 0.0), np.maximum(np.maximum(y0 - y, y - y1), 0.0))
            out[(gap < 0.7) & (box[:, 2] < z1 + 0.05)] = DRAWER_NEAR_M
    return out


def _excess_m(known: SemanticMap, tracks: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m,) by how much the box of each track may be wider than the thing, metres.

    The thing may be farther away than its box by this much: a box holds some of what is next to the thing.
    """
    sides = known.box[tracks, 3:5] - known.box[tracks, :2]
    loose = 0.0 if known.hypotheses is None else LOOSE * sides.max(1)
    return np.asarray(loose + np.maximum(sides.max(1) - [_widest_m(known.category[k]) for k in tracks.tolist()], 0.0))


@lru_cache(maxsize=2048)
def _widest_m(category: str) -> float:
    """Longer horizontal side of a category in metres; infinite outside the catalogue."""
    book = catalogue()
    return float(max(book[category].size[:2])) if category in book else np.inf


def _center(box: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centre (3,) of a box (6,)."""
    return 0.5 * (box[:3] + box[3:])


@lru_cache(maxsize=8)
def _eyes_of(looks: tuple[tuple[int, float, int], ...]) -> NDArray[np.float64]:
    """See :func:`_eyes`; computed once for each body."""
    return np.array([(eye_m, np.cos(np.deg2rad(p)), np.sin(np.deg2rad(p)), look) for look, eye_m, p in looks])


def _eyes(body: Body) -> NDArray[np.float64]:
    """(L, 4) height in metres, cosine and sine of the pitch, look in degrees; the level look first."""
    return _eyes_of(tuple((look, eye_m, pitch) for look, (eye_m, pitch) in body.eyes.items()))
