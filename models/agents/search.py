"""The searching controller that ``frontier`` and ``belief`` share; they differ in where they expect the target.

It maps what it sees, goes to the view with the most expected mass for its cost, opens what is closed and worth it,
and walks up to the target once a detection of its category appears.
"""

from __future__ import annotations

from collections import deque
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from models.agents.base import Info, Observation
from ucon.objects.catalogue import catalogue
from ucon.perception.body import Body
from ucon.perception.containers import Containers, open_reach_m
from ucon.perception.homing import Homing
from ucon.perception.places import INSIDE, Places, sight_range_m
from ucon.perception.planner import Planner
from ucon.perception.semantic_map import SemanticMap, frame_depth
from ucon.perception.viewpoints import Choice, Costs, Expectation, Viewpoints
from ucon.task.actions import Action

#: A container that did not open this often is let be.
MOST_REFUSALS = 3


class Expecting(Protocol):
    """Says where the target may be, given what was seen."""

    def expect(self, known: SemanticMap, places: Places) -> Expectation:
        """Mass of tracks, unexplored space and space seen from afar."""
        ...

    def reread(self, known: SemanticMap, places: Places) -> bool:
        """Called before a view is chosen: read anew what depends on what was seen; True if that changed anything."""
        ...


class SearchController:
    """Searches one home for one target."""

    REPLAN_STEPS = 5
    #: A frame that shows a place from within sight range still misses the target with this probability.
    MISS = 0.1

    def __init__(self, info: Info, expecting: Expecting, costs: Costs | None = None) -> None:
        self.target = str(info["target"])
        book = catalogue()
        height_m = book[self.target].size[2] if self.target in book else 0.1
        self.map = SemanticMap(Body.of(info))
        self.planner = Planner(info.get("nav"))
        self.places = Places(height_m)
        self.viewpoints = Viewpoints(sight_range_m(self.target), costs)
        self.containers = Containers()
        self.homing = Homing()
        self.expecting = expecting
        self.choice: Choice | None = None
        self.refused: dict[int, int] = {}
        self._plan: deque[Action] = deque()
        self._age = 0

    def act(self, observation: Observation, info: Info) -> int:
        """The next action."""
        self._look(observation, info)
        if int(observation["collision"]):
            self._plan.clear()
        track = self._target_track()
        if track is not None:
            return int(self.homing.act(self.map, self.planner, track, blocked=bool(observation["collision"])))
        expected = self.expecting.expect(self.map, self.places)
        return int(self._open_here(expected) or self._search(expected))

    def _look(self, observation: Observation, info: Info) -> None:
        known = self.map
        known.update(observation, info)
        self.places.refresh(known)
        shut = np.zeros(known.n_tracks, bool)
        shut[self.closed()] = True
        active, reach = self.places.searched(shut), self.viewpoints.reach_m
        self.places.look(known, frame_depth(observation, info), active, reach, self.MISS)

    def closed(self) -> NDArray[np.int64]:
        """Tracks of containers that are closed and may still open."""
        return self.containers.closed(self.map)

    def _target_track(self) -> int | None:
        tracks = self.map.instances.get(self.target, ())
        return next((t for t in tracks if self.map.seen(t)), None)

    def _open_here(self, expected: Expectation) -> Action | None:
        """Open what is closed, in view and in reach, where that is worth a step."""
        tracks = self.containers.in_reach(self.map)
        worth = 0.0
        for track in tracks:
            worth += expected.mass[track, INSIDE] * 0.5 ** self.refused.get(track, 0)
        bar = 0.0 if self.choice is None else self.choice.score
        if not tracks or worth / self.viewpoints.costs.open < max(bar, 1e-6):
            return None
        if all(self.refused.get(t, 0) >= MOST_REFUSALS for t in tracks):
            return None
        for track in tracks:
            self.refused[track] = self.refused.get(track, 0) + 1
        return Action.OPEN

    def _search(self, expected: Expectation) -> Action:
        arrived = self.choice is not None and self.map.view == self.choice.view
        if arrived:
            self._closed_after_all()
            self.viewpoints.disappoint(self.map, self.places, expected, self._openable_now())
            self.choice = None
        if self.choice is None or not self._plan or self._age >= self.REPLAN_STEPS:
            if self.expecting.reread(self.map, self.places):
                expected = self.expecting.expect(self.map, self.places)
            self._choose(expected)
        self._age += 1
        return self._plan.popleft() if self._plan else Action.ROTATE_LEFT

    def _closed_after_all(self) -> None:
        """Lose faith in opening what this view was chosen to open and does not show."""
        if self.choice is not None and self.choice.opens:
            for track in self.closed():
                if self.map.gap_m(int(track), self.map.view.xy) <= open_reach_m(self.map):
                    self.refused[int(track)] = self.refused.get(int(track), 0) + 1

    def _openable_now(self) -> NDArray[np.int64]:
        return np.array([t for t in self.closed() if self.refused.get(int(t), 0) < MOST_REFUSALS], np.int64)

    def _choose(self, expected: Expectation) -> None:
        self.planner.update(self.map)
        keep = self.choice.view if self.choice is not None else None
        for _ in range(4):
            best, kept = self.viewpoints.choose(
                self.map, self.planner, self.places, expected, self._openable_now(), keep
            )
            if kept is not None and best is not None and kept.score * 1.25 >= best.score and kept.gain > 0.0:
                best = kept
            if best is None or best.view != self.map.view:
                break
            self.viewpoints.disappoint(self.map, self.places, expected, self._openable_now())
        if best is None or best.gain <= 1e-9:
            self._second_look()
            best = self.viewpoints.elsewhere(self.map, self.planner)
        self.choice, self._age = best, 0
        self._plan = deque(self.planner.plan(best.view)) if best is not None else deque()

    def _second_look(self) -> None:
        """Everything was looked at: believe that some looks missed it, and go round again from nearer."""
        self.places.unseen[:] = np.maximum(self.places.unseen, 0.3)
        self.viewpoints.stale[:] = 1.0
        self.viewpoints.reach_m = max(1.2, 0.7 * self.viewpoints.reach_m)
        self.refused.clear()
