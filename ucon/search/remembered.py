"""Remembered places of the target, where the detector errs: what stands there is taken for the target.

A detector that misses the target from one side misses it from there every day. But a robot that knows where a thing is
kept need not recognise it: if something of its size stands at its place, that is probably it.
"""

from __future__ import annotations

from collections import deque
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.perception.belief.recalled import Recalled
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap, View
from ucon.perception.places.occupied import Occupied
from ucon.perception.views.approach import Approach
from ucon.task.actions import Action

#: A place at least this probable is walked up to, and Done is called there.
TAKE: Final = 0.7
#: The seen part of a thing may be nearer than the thing by this, metres.
NEARER_M: Final = 0.1
#: Something else stands at a place if a thing on the map overlaps it by more than this intersection over union, was
#: found from at least this many sides, and is the target with less than this probability.
SAME, LOOKS, OTHER = 0.2, 3, 0.05
#: A place is given up after this many poses from which nothing was seen there.
MOST_POSES: Final = 2


class RememberedPlaces(PartlyShared):
    """The remembered places of the target in one search.

    Attributes:
        p: (n,) probability that the target is at each of them, by memory and by what depth shows.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"_recalled"})
    _flat: ClassVar[frozenset[str]] = frozenset({"_plan", "_failed", "p"})

    def __init__(self, recalled: Recalled) -> None:
        """Start a search.

        Args:
            recalled: where the target was seen before; places without sizes are not checked.
        """
        self._recalled, self.p = recalled, recalled.p
        self._occupied = Occupied(recalled.xyz, recalled.size, recalled.spots or [()] * len(recalled.xyz))
        self._plan: deque[Action] = deque()
        self._going = -1
        self._failed = np.zeros(len(recalled.xyz), np.int64)

    def look(self, known: SemanticMap, depth: NDArray[np.float32]) -> None:
        """Take in a frame.

        Args:
            known: the map with the frame.
            depth: (H, W), metres.
        """
        if not len(self.p):
            return
        self._occupied.look(known, depth)
        weight = self._recalled.p * self._occupied.likelihood()
        whole = 1.0 - float(self._recalled.p.sum()) + float(weight.sum())
        self.p = weight / whole if whole > 0.0 else self._recalled.p

    def act(
        self, known: SemanticMap, planner: Planner, approach: Approach, rival: float, *, blocked: bool
    ) -> Action | None:
        """The next action towards the likeliest place where something stands, or Done there.

        Args:
            known: the map with the newest frame.
            planner: updated here when a new plan is due.
            approach: finds the pose to walk to.
            rival: probability of the best suspect that the detector found; less probable places are left alone.
            blocked: whether the last move failed.

        Returns:
            None where there is no such place.
        """
        standing = np.where(self._occupied.stands & (self._failed < MOST_POSES), self.p, 0.0)
        best = int(standing.argmax()) if len(standing) else -1
        if best < 0 or standing[best] < max(TAKE, rival) or self._is_something_else(known, best):
            self._going = -1
            return None
        if self._is_here(known, best):
            return Action.DONE
        if best != self._going or blocked:
            self._going, self._plan = best, deque()
            view = self._view(known, planner, approach, best)
            self._plan = deque(planner.plan(view)) if view is not None else deque()
        if self._plan:
            return self._plan.popleft()
        approach.failed(known.view)
        self._failed[best] += 1
        self._going = -1
        return None

    def _is_something_else(self, known: SemanticMap, place: int) -> bool:
        """Whether a thing on the map that is not the target stands there, such as a chair once taken for a bench."""
        assert known.hypotheses is not None
        n, half = known.n_tracks, 0.5 * self._recalled.size[place]
        box = np.concatenate([self._recalled.xyz[place] - half, self._recalled.xyz[place] + half])
        common = np.minimum(known.box[:n, 3:], box[3:]) - np.maximum(known.box[:n, :3], box[:3])
        shared = np.maximum(common, 0.0).prod(1)
        whole = np.maximum(known.box[:n, 3:] - known.box[:n, :3], 0.0).prod(1) + (box[3:] - box[:3]).prod() - shared
        found, _ = known.hypotheses.support(n)
        rows = np.flatnonzero((shared > SAME * whole) & (found >= LOOKS) & (known.kind[:n] == 0))
        return any(known.hypotheses.p_target[row] < OTHER for row in rows.tolist())

    def _is_here(self, known: SemanticMap, place: int) -> bool:
        """Whether something is seen to stand at a place, near enough for Done."""
        box, (x, y) = self._occupied.boxes[place], known.view.xy
        gap_m = float(np.hypot(max(box[0] - x, x - box[3], 0.0), max(box[1] - y, y - box[4], 0.0)))
        return self._occupied.now[place] >= MIN_PIXELS and gap_m <= known.body.near_m - NEARER_M

    def _view(self, known: SemanticMap, planner: Planner, approach: Approach, place: int) -> View | None:
        """The cheapest pose from which a place should be seen, near enough for Done."""
        planner.update(known)
        return approach.pose_at(known, planner, self._occupied.boxes[place], known.body.near_m - NEARER_M)
