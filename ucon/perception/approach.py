"""Walking up to a thing that was seen: where to stand, which way to look, when to say Done."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ucon.perception.body import Body
from ucon.perception.detections import MIN_PIXELS
from ucon.perception.places import affordance
from ucon.perception.planner import UNREACHED, Planner
from ucon.perception.semantic_map import CELL_M, HALF, SemanticMap, View
from ucon.perception.view_kernels import sight

#: Content of a drawer shows where the drawer took it; its box stays where it was, farther back.
DRAWER_NEAR_M = 0.55


class Approach:
    """Finds poses from which a track is visible and in reach, forgetting those that did not work."""

    def __init__(self) -> None:
        self._failed: dict[View, int] = {}
        self._best = (0.0, 1.0)

    def arrived(self, known: SemanticMap, track: int) -> bool:
        """Whether Done would succeed now, as far as the map can tell."""
        return bool(known.pixels[track] >= MIN_PIXELS) and known.gap_m(track, known.view.xy) <= self.reach_m(
            known, track
        )

    def reach_m(self, known: SemanticMap, track: int) -> float:
        """How near the seen part must be: less where the thing may have come out with a drawer."""
        x, y = _center(known.box[track])[:2]
        for holder in np.flatnonzero(known.opened[: known.n_tracks]):
            x0, y0, _, x1, y1, z1 = known.box[holder]
            out = np.hypot(max(x0 - x, x - x1, 0.0), max(y0 - y, y - y1, 0.0))
            name = known.category[holder]
            if out < 0.7 and known.box[track, 2] < z1 + 0.05 and name and affordance(name).drawers:
                return DRAWER_NEAR_M
        return known.body.near_m - 0.005

    def failed(self, view: View) -> None:
        """Remember that the thing was not visible from a view."""
        self._failed[view] = self._failed.get(view, 0) + 1

    def goal(self, known: SemanticMap, planner: Planner, track: int) -> View | None:
        """The cheapest pose that should do, or None; the planner must be up to date."""
        center = _center(known.box[track])
        self._note(known, track)
        reach = self.reach_m(known, track)
        best, best_cost = None, float(UNREACHED)
        for i, j in self._nodes(known, planner, track, reach):
            x, y = (i - HALF) * CELL_M, (j - HALF) * CELL_M
            for view, depth in _facing(i, j, center - (x, y, 0.0), known.body):
                eye_m = known.body.eyes[view.pitch_deg][0]
                clear = sight(x, y, eye_m, center[0], center[1], center[2], known.height, known.walls, HALF)
                cost = planner.cost(view) + (0 if clear else 25) + (0 if self._pixels(depth) >= 6 else 4)
                cost += 30 * self._failed.get(view, 0)
                if cost < best_cost:
                    best, best_cost = view, float(cost)
        return best

    def _nodes(self, known: SemanticMap, planner: Planner, track: int, reach_m: float) -> list[tuple[int, int]]:
        x0, y0, _, x1, y1, _ = known.box[track]
        i0, i1 = int((x0 - reach_m) / CELL_M) + HALF - 1, int((x1 + reach_m) / CELL_M) + HALF + 2
        j0, j1 = int((y0 - reach_m) / CELL_M) + HALF - 1, int((y1 + reach_m) / CELL_M) + HALF + 2
        reached = planner.steps[i0:i1, j0:j1].min(2) < UNREACHED
        nodes = [(int(i) + i0, int(j) + j0) for i, j in np.argwhere(reached)]
        return [n for n in nodes if known.gap_m(track, ((n[0] - HALF) * CELL_M, (n[1] - HALF) * CELL_M)) <= reach_m]

    def _note(self, known: SemanticMap, track: int) -> None:
        """Keep the best sight so far, to tell how many pixels a nearer view will have."""
        if known.pixels[track] > self._best[0]:
            gap = _center(known.box[track]) - (*known.view.xy, known.body.eyes[known.view.pitch_deg][0])
            self._best = (float(known.pixels[track]), float(np.linalg.norm(gap)))

    def _pixels(self, depth_m: float) -> float:
        pixels, distance = self._best
        return pixels * (distance / max(depth_m, 0.1)) ** 2


def _center(box: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5 * (box[:3] + box[3:])


def _facing(i: int, j: int, offset: NDArray[np.float64], body: Body) -> list[tuple[View, float]]:
    """Views at a node that have a point ``offset`` (3,) from the floor there well inside the frame, with its depth."""
    out = []
    for heading in range(4):
        c, s = (1, 0, -1, 0)[heading], (0, 1, 0, -1)[heading]
        flat, side = c * offset[0] + s * offset[1], abs(s * offset[0] - c * offset[1])
        for look, (eye_m, pitch) in body.eyes.items():
            cp, sp = np.cos(np.deg2rad(pitch)), np.sin(np.deg2rad(pitch))
            rise = offset[2] - eye_m
            optical, up = cp * flat + sp * rise, cp * rise - sp * flat
            if optical > 0.1 and side <= 0.93 * optical and abs(up) <= 0.93 * optical:
                out.append((View(i, j, heading, look), float(optical)))
    return out
