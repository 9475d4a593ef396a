"""Search with a detector that errs: which thing to walk up to, look at again, take for the target, or give up.

A *suspect* is a thing on the map that may be the target. Walking up to one and going to look elsewhere are compared by
the probability of finding the target over the cost. Done ends the search where the suspect is probable enough; near the
end of the episode the best suspect is taken as it is.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared, Shared
from ucon.perception.hypotheses.look_kernels import NEVER
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.planner import UNREACHED
from ucon.perception.mapping.semantic_map import CELL_M, HALF, SemanticMap, View, camera_of
from ucon.perception.views.view_kernels import sight
from ucon.search.search_decision import Seeking
from ucon.search.suspects import Judge, Suspects
from ucon.task.actions import Action


@dataclass(frozen=True)
class Doubts(Shared):
    """Where doubt ends."""

    consider: float = 0.03
    """Less probable suspects are not walked up to."""
    take: float = 0.7
    """Done is said at a suspect that is this probable,"""
    settle: float = 0.4
    """or this, where there is no new side to see it from."""
    last_steps: int = 30
    """When so many steps are left, the best suspect is taken."""
    most_looks: int = 3
    """Further looks at a suspect within reach."""


class Doubt(PartlyShared):
    """The suspects of one search.

    Attributes:
        suspect: track that is being walked up to; -1 where there is none.
        p: by track, the probability of each suspect.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"p", "_plan", "_given_up"})

    def __init__(self, steps: int, judge: Judge | None = None, doubts: Doubts | None = None) -> None:
        """Start an episode of so many steps."""
        self._steps = steps
        self.suspects = Suspects(judge)
        self._w = doubts or Doubts()
        self.suspect = -1
        self.p: dict[int, float] = {}
        self._chosen_at = 0.0
        self._plan: deque[Action] = deque()
        self._looks = 0
        self._given_up: dict[int, int] = {}

    def act(self, search: Seeking, depth: NDArray[np.float32], blocked: bool) -> Action | None:
        """The next action at or towards a suspect; None where the search goes on elsewhere."""
        known, w = search.map, self._w
        self.suspects.look(search)
        self.p = self.suspects.p
        left = self._steps - known.step
        if blocked:
            self._plan.clear()
        if left <= w.last_steps and self.p:
            return self._last(search, depth, left, blocked)
        if self.suspect >= 0:
            p = self.p.get(self.suspect, 0.0)
            if p < max(w.consider, 0.4 * self._chosen_at):
                self._give_up(known)
        if self.suspect < 0:
            self._choose(search)
        if self.suspect < 0:
            return None
        return self._at(search, depth, blocked)

    def _at(self, search: Seeking, depth: NDArray[np.float32], blocked: bool) -> Action | None:
        """The next action at or towards the suspect."""
        known, track, w = search.map, self.suspect, self._w
        p = self.p[track]
        if self._within_reach(search, depth, track):
            if p >= w.take:
                return Action.DONE
            if not self._plan:
                view = self._other_side(search, track) if self._looks < w.most_looks else None
                self._looks += 1
                if view is not None:
                    self._plan = deque(search.planner.plan(view))
                if not self._plan:
                    if p >= w.settle:
                        return Action.DONE
                    self._give_up(known)
                    return None
            return self._plan.popleft()
        if self._plan:
            return self._plan.popleft()
        return search.homing.act(known, search.planner, track, blocked=blocked)

    def _last(self, search: Seeking, depth: NDArray[np.float32], left: int, blocked: bool) -> Action | None:
        """The best suspect is taken with the last steps."""
        track = max(self.p, key=lambda t: (self.p[t], -t))
        if track != self.suspect:
            self.suspect, self._plan = track, deque()
        if self._within_reach(search, depth, track):
            return Action.DONE
        return search.homing.act(search.map, search.planner, track, blocked=blocked)

    def _give_up(self, known: SemanticMap) -> None:
        """Go on elsewhere; the suspect may be chosen again when more was seen of it."""
        assert known.hypotheses is not None
        self._given_up[self.suspect] = len(known.hypotheses.looks[self.suspect])
        self.suspect, self._looks, self._plan = -1, 0, deque()

    def _choose(self, search: Seeking) -> None:
        """Choose the suspect that is worth more than the best view, if there is one."""
        known, w = search.map, self._w
        assert known.hypotheses is not None and search.expected is not None
        looks = known.hypotheses.looks
        tracks = [t for t, p in self.p.items() if p >= w.consider and len(looks[t]) > self._given_up.get(t, -1)]
        if not tracks:
            return
        decision = search.decision()
        rows = np.array(tracks, np.int64)
        _, costs = search.homing.approach.goals(known, search.planner, rows)
        value = np.array([self.p[t] for t in tracks]) / (np.where(costs < UNREACHED, costs, 60) + 1.0)
        best = int(value.argmax())
        score = 0.0 if decision.best is None or decision.valued is None else decision.best.score
        if value[best] >= score / search.expected.unit:
            self.suspect, self._chosen_at = tracks[best], self.p[tracks[best]]
            self._looks, self._plan = 0, deque()

    def _within_reach(self, search: Seeking, depth: NDArray[np.float32], track: int) -> bool:
        """Whether Done would succeed if the suspect is the target: near enough, and in view whether found or not."""
        known, approach = search.map, search.homing.approach
        if not approach.near(known, track):
            return False
        return bool(known.pixels[track] >= MIN_PIXELS) or _in_view(known, depth, track)

    def _other_side(self, search: Seeking, track: int) -> View | None:
        """The cheapest view of a suspect from a side and distance that it was not seen from."""
        known, planner = search.map, search.planner
        hypotheses = known.hypotheses
        assert hypotheses is not None
        planner.update(known)
        box = known.box[track]
        x, y, z = (0.5 * (box[:3] + box[3:])).tolist()
        ci, cj = round(x / CELL_M) + HALF, round(y / CELL_M) + HALF
        best, lowest = None, 13.0
        for i in range(ci - 9, ci + 10):
            for j in range(cj - 9, cj + 10):
                steps = planner.steps[i, j]
                if steps.min() >= lowest or not known.explored[i, j]:
                    continue
                dx, dy = x - (i - HALF) * CELL_M, y - (j - HALF) * CELL_M
                flat = float(np.hypot(dx, dy))
                if flat < 0.2:
                    continue
                heading = (0 if dx > 0 else 2) if abs(dx) >= abs(dy) else (1 if dy > 0 else 3)
                if steps[heading] >= lowest:
                    continue
                for look, (eye_m, pitch) in known.body.eyes.items():
                    rise = np.rad2deg(np.arctan2(z - eye_m, flat))
                    if abs(rise - pitch) > 38.0:
                        continue
                    cost = float(steps[heading]) + abs(look - known.view.pitch_deg) // 30
                    if cost >= lowest or hypotheses.state_from(track, dx, dy, z - eye_m) != NEVER:
                        continue
                    if sight((i - HALF) * CELL_M, (j - HALF) * CELL_M, eye_m, x, y, z, known.height, known.walls, HALF):
                        best, lowest = View(i, j, heading, look), cost
        return best


def _in_view(known: SemanticMap, depth: NDArray[np.float32], track: int) -> bool:
    """Whether the middle of a thing is in the picture and nothing nearer hides it."""
    x, y, z, c, s, cp, sp, focal_px = camera_of(known.view, depth, known.body).tolist()
    box = known.box[track]
    px, py, pz = (0.5 * (box[:3] + box[3:])).tolist()
    dx, dy, dz = px - x, py - y, pz - z
    ahead, right = c * dx + s * dy, s * dx - c * dy
    optical, up = cp * ahead + sp * dz, cp * dz - sp * ahead
    if optical < 0.1:
        return False
    rows, columns = depth.shape
    u, v = int(0.5 * columns + focal_px * right / optical), int(0.5 * rows - focal_px * up / optical)
    if not (0 <= u < columns and 0 <= v < rows):
        return False
    half = 0.5 * float((box[3:] - box[:3]).max())
    return bool(depth[v, u] >= optical - half - 0.1)
