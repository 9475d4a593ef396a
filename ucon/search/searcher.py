"""Search by gain over cost: maps each frame, values every view, walks to the chosen one, opens containers on the way.

``frontier``, ``belief`` and the habit policy share it, so that they differ only in the expected mass and in the choice.
Unlike :class:`~ucon.search.explorer.Explorer`, it asks for a new choice every few steps, opens containers on the way,
and looks around only where a view was chosen for it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.objects.catalogue import catalogue
from ucon.perception.belief.protocol import Expecting
from ucon.perception.belief.recalled import Remembering, remembering
from ucon.perception.mapping.planner import Planner
from ucon.perception.mapping.semantic_map import SemanticMap, View, frame_depth
from ucon.perception.places.affordances import sight_range_m
from ucon.perception.places.containers import Containers, open_reach_m
from ucon.perception.places.place_kernels import INSIDE
from ucon.perception.places.sight import Sight
from ucon.perception.places.target_places import Places
from ucon.perception.views.homing import Homing
from ucon.perception.views.viewpoints import Choice, Costs, Expectation, Viewpoints, ViewValues
from ucon.search.doubt import Doubt, Doubts
from ucon.search.remembered import RememberedPlaces
from ucon.search.search_decision import SearchDecision
from ucon.search.suspects import Judge
from ucon.task.actions import Action, decoded_action
from ucon.task.rules import PAPER, task_rules

Info = Mapping[str, Any]
#: A container on which Open failed this often is not tried again.
MOST_REFUSALS = 3
#: The view that the agent is on its way to stays chosen unless another one is better by this factor.
LOYALTY = 1.25
#: Probability that a frame that shows a place from within sight range misses a target there.
MISS = 0.1


class Searcher(PartlyShared):
    """One search by gain over cost for one target, in one episode.

    Each step, :meth:`look` takes in the frame. It returns an action, or None where a choice is due; then
    :meth:`decision` gives the views and :meth:`choose` returns the action.

    Attributes:
        target: category of the target.
        map: the agent's map.
        planner: paths on it.
        places: sample points on it.
        viewpoints: values views.
        expecting: gives the expected mass.
        expected: the current expected mass; None before the first frame.
        choice: the view that the agent is on its way to, or None.
        refused: by track, how often Open failed.
        taking: whether the target was found and the agent is walking up to it.
        decisions: how many choices were made.
        remembered: places where the target was seen before; None without any, and where the detector does not err.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"refused", "_plan", "_opened_at"})

    REPLAN_STEPS = 5

    def __init__(
        self,
        info: Info,
        expecting: Expecting,
        costs: Costs | None = None,
        miss: float = MISS,
        judge: Judge | None = None,
        doubts: Doubts | None = None,
    ) -> None:
        """Start an episode.

        Args:
            info: the info at the reset.
            expecting: gives the expected mass; a new object, used for this episode only.
            costs: of moves, rotations and looks; defaults where None.
            judge: gives the probabilities of suspects, where the detector errs; None: the arithmetic posterior.
            doubts: thresholds for suspects, where the detector errs; defaults where None.
            miss: probability that a frame that shows a place from within sight range misses a target there. At 1
                nothing is learned from looking in vain.
        """
        self.target = str(info["target"])
        book = catalogue()
        height_m = book[self.target].size[2] if self.target in book else 0.1
        self.map = SemanticMap.of(info)
        self.planner = Planner(info.get("nav"), self.map.body)
        errors = info.get("detector_errors")
        self.places = Places(height_m, None if errors is None else Sight.of(errors, self.target))
        self.viewpoints = Viewpoints(sight_range_m(self.target), costs)
        self.containers = Containers()
        self.homing = Homing()
        self.expecting = remembering(expecting, info)
        recalled = info.get("recalled")
        self.remembered = (
            None
            if self.map.hypotheses is None or recalled is None or not len(recalled.size)
            else RememberedPlaces(recalled)
        )
        self.miss = miss
        self.choice: Choice | None = None
        self.refused: dict[int, int] = {}
        self.taking = False
        self.decisions = 0
        self.expected: Expectation | None = None
        self.doubt = (
            None
            if self.map.hypotheses is None
            else Doubt(task_rules(str(info.get("task", PAPER.name))).max_steps, judge, doubts)
        )
        self._decision: SearchDecision | None = None
        self._plan: deque[Action] = deque()
        self._said: Action | None = None
        self._opening: tuple[int, ...] = ()
        self._opened_at: set[View] = set()
        self._age = 0

    def look(self, observation: Mapping[str, Any], info: Info) -> Action | None:
        """Take in a frame.

        If the action done last is not the one returned last, the current plan is dropped.

        Args:
            observation: of the frame.
            info: of the frame.

        Returns:
            The next action, or None where a choice is due.
        """
        strayed = self._said is not None and _did(observation, self._said) != self._said
        if strayed:
            self._take_back()
        self.observe(observation, info)
        blocked = strayed or bool(observation["collision"])
        if blocked:
            self._plan.clear()
        self._said = action = self._next(observation, info, blocked)
        return action

    def _next(self, observation: Mapping[str, Any], info: Info, blocked: bool) -> Action | None:
        """The next action after a frame was taken in; None where a choice is due."""
        if self.doubt is not None:
            self.expect()
            action = self._take_remembered(blocked)
            if action is None:
                action = self.doubt.act(self, frame_depth(observation, info), blocked)
            self.taking = self.doubt.suspect >= 0
            if action is not None:
                self.choice = None
                return action
            assert self.expected is not None
            return self._open_here(self.expected) or self._go_on(self.expected)
        track = self._target_track()
        if track is not None:
            self.taking = True
            return self.homing.act(self.map, self.planner, track, blocked=blocked)
        self.expect()
        assert self.expected is not None
        return self._open_here(self.expected) or self._go_on(self.expected)

    def _take_remembered(self, blocked: bool) -> Action | None:
        """Walk up to a remembered place where something stands, if no suspect is more probable."""
        assert self.doubt is not None
        if self.remembered is None:
            return None
        rival = max(self.doubt.p.values(), default=0.0)
        return self.remembered.act(self.map, self.planner, self.homing.approach, rival, blocked=blocked)

    def observe(self, observation: Mapping[str, Any], info: Info) -> None:
        """Add a frame to the map and note which places it shows; no action is computed.

        Args:
            observation: of the frame.
            info: of the frame.
        """
        self._decision = None
        known = self.map
        known.update(observation, info)
        self.places.refresh(known)
        shut = np.zeros(known.n_tracks, bool)
        shut[self.closed()] = True
        active, reach = self.places.searched(shut), self.viewpoints.reach_m
        depth = frame_depth(observation, info)
        self.places.look(known, depth, active, reach, self.miss)
        if self.remembered is not None:
            self.remembered.look(known, depth)
            assert isinstance(self.expecting, Remembering)
            self.expecting.weigh(self.remembered.p)

    def expect(self) -> None:
        """Compute ``expected`` from the current map."""
        self.expected = self.expecting.expect(self.map, self.places)

    def decision(self) -> SearchDecision:
        """The choice that is due, computed once a frame. Only where :meth:`look` returned None.

        At habit level ``context`` the habits are read again first, if their list changed.
        """
        if self._decision is None:
            assert self.expected is not None
            if self.expecting.reread(self.map, self.places):
                self.expected = self.expecting.expect(self.map, self.places)
            self._decision = self._decide(self.expected)
        return self._decision

    def choose(self, choice: Choice | None) -> Action:
        """Make the choice that is due.

        Args:
            choice: the view to go to; None turns left.

        Returns:
            The first action towards it.
        """
        self.choice, self._age = choice, 1
        self.decisions += 1
        self._decision = None
        self._plan = deque(self.planner.plan(choice.view)) if choice is not None else deque()
        self._said = self._plan.popleft() if self._plan else Action.ROTATE_LEFT
        return self._said

    def closed(self) -> NDArray[np.int64]:
        """Tracks of containers that were not opened yet, (c,) int64."""
        return self.containers.closed(self.map)

    def _target_track(self) -> int | None:
        """The first track of the target that was seen, or None."""
        tracks = self.map.instances.get(self.target, ())
        return next((t for t in tracks if self.map.seen(t)), None)

    def _open_here(self, expected: Expectation) -> Action | None:
        """Open, if a closed container is in view and within reach and the mass inside is worth a step; else None."""
        tracks = self.containers.in_reach(self.map)
        worth = 0.0
        for track in tracks:
            worth += expected.mass[track, INSIDE] * 0.5 ** self.refused.get(track, 0)
        bar = 0.0 if self.choice is None else self.choice.score
        if not tracks or worth / self.viewpoints.costs.open < max(bar, 1e-6):
            return None
        if all(self.refused.get(t, 0) >= MOST_REFUSALS for t in tracks):
            return None
        if self.doubt is not None or not self.map.body.exact:
            if self.map.view in self._opened_at:
                return None  # what did not open from here does not open at all, or is no container
            self._opened_at.add(self.map.view)
        for track in tracks:
            self.refused[track] = self.refused.get(track, 0) + 1
        self._opening = tuple(tracks)
        return Action.OPEN

    def _take_back(self) -> None:
        """Forget an Open that was returned but not done."""
        if self._said is Action.OPEN:
            for track in self._opening:
                self.refused[track] = self.refused.get(track, 1) - 1
            self._opened_at.discard(self.map.view)

    def _go_on(self, expected: Expectation) -> Action | None:
        """The next action of the walk; None where a choice is due."""
        arrived = self.choice is not None and self.map.view == self.choice.view
        if arrived:
            self._closed_after_all()
            self.viewpoints.lower_expectations(self.map, self.places, expected, self.openable_now())
            self.choice = None
        if self.choice is None or not self._plan or self._age >= self.REPLAN_STEPS:
            return None
        self._age += 1
        return self._plan.popleft()

    def _closed_after_all(self) -> None:
        """On arrival at a view that was chosen for opening: count the containers within reach as failed."""
        if self.choice is not None and self.choice.opens:
            for track in self.closed():
                if self.map.gap_m(int(track), self.map.view.node_xy) <= open_reach_m(self.map):
                    self.refused[int(track)] = self.refused.get(int(track), 0) + 1

    def openable_now(self) -> NDArray[np.int64]:
        """Tracks of closed containers on which Open failed fewer than ``MOST_REFUSALS`` times, (c,) int64."""
        return np.array([t for t in self.closed() if self.refused.get(int(t), 0) < MOST_REFUSALS], np.int64)

    def _decide(self, expected: Expectation) -> SearchDecision:
        """Value all views.

        Where the best one is the current pose, its expectations are lowered and the views are valued again.
        """
        self.planner.update(self.map)
        keep = self.choice.view if self.choice is not None else None
        known, places, closed = self.map, self.places, self.openable_now()
        valued, best = None, None
        for _ in range(4):
            valued = self.viewpoints.value(known, self.planner, places, expected, closed, keep)
            best = None if valued is None else _best_or_kept(valued)
            if best is None or best.view != known.view:
                break
            self.viewpoints.lower_expectations(known, places, expected, closed)
        if best is None or best.gain <= 1e-9:
            self._second_look()
            valued, best = None, self.viewpoints.nearest_unvisited(known, self.planner)
        return SearchDecision(self.decisions, known.step, best, valued, expected, closed)

    def _second_look(self) -> None:
        """Start the search over, where no view has any gain: restore part of ``unseen``, and look from nearer."""
        self.places.unseen[:] = np.maximum(self.places.unseen, 0.3)
        self.viewpoints.stale[:] = 1.0
        self.viewpoints.reach_m = max(1.2, 0.7 * self.viewpoints.reach_m)
        self.refused.clear()


def _did(observation: Mapping[str, Any], said: Action) -> Action | None:
    """The action that was done last; None at the start. Where the observation lacks it, ``said`` counts as done."""
    if "last_action" not in observation:
        return said
    code = decoded_action(observation["last_action"])
    return Action(code) if code < len(Action) else None


def _best_or_kept(valued: ViewValues) -> Choice:
    """The best view, or the one that the agent is on its way to if that is nearly as good (``LOYALTY``)."""
    best, kept = valued.best, valued.kept
    return kept if kept is not None and kept.score * LOYALTY >= best.score and kept.gain > 0.0 else best
