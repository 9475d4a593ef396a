"""Carries out choices among candidates in one episode: walks there, looks around, opens, and goes to the target.

All agents that choose among candidates share it, so that they differ only in how they choose. Every action costs a
step.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from ucon.core.compass import heading_to
from ucon.core.errors import ConfigError, brief
from ucon.core.rng import stream
from ucon.core.sharing import PartlyShared
from ucon.perception.mapping.detections import MIN_PIXELS
from ucon.perception.mapping.planner import UNREACHED, Planner
from ucon.perception.mapping.semantic_map import CELL_M, SemanticMap, View
from ucon.perception.mapping.sightings import Sighting
from ucon.perception.places.containers import Containers
from ucon.perception.views.candidates import Candidate
from ucon.perception.views.homing import Homing
from ucon.search.strategies import Strategy
from ucon.task.actions import Action

Info = Mapping[str, Any]
#: When seeing the target ends the search: at once (``always``), only while looking around on arrival (``around``), or
#: only after a direction that shows the target was chosen (``chosen``).
Interrupt = Literal["always", "around", "chosen"]
#: Random nodes are at least this far away, metres.
_WANDER_M = 1.0


@dataclass(frozen=True)
class Manner:
    """How choices are carried out.

    Raises:
        ConfigError: at construction, if ``replan_steps`` is not a whole number from 0 up.
    """

    look_around: bool = True
    """Turn through all headings on arrival, and at the start of the episode."""
    opens: bool = True
    """On arrival, Open once in each heading where a closed container is in view and within reach."""
    interrupt: Interrupt = "always"
    """When seeing the target ends the search."""
    replan_steps: int = 0
    """A new choice is due after this many actions of a walk; 0: on arrival only."""

    def __post_init__(self) -> None:
        if type(self.replan_steps) is not int or self.replan_steps < 0:
            raise ConfigError(f"agent.replan_steps={brief(self.replan_steps)}: expected a whole number from 0 up")


@dataclass(frozen=True, eq=False)
class Decision:
    """A choice among candidates that is due."""

    number: int
    """Number of the decision in its episode, from 0."""
    step: int
    """Step of the newest frame, from 0."""
    target: str
    """Category of the target."""
    candidates: tuple[Candidate, ...]
    """At least one."""
    known: SemanticMap
    """The agent's map."""
    sightings: tuple[Sighting, ...]
    """What was seen around the current node, for prompts."""
    draw: np.random.Generator
    """Random numbers of this decision; they depend on seed, episode and number alone."""


class Explorer(PartlyShared):
    """One search by choices among candidates, in one episode.

    Each step, :meth:`look` takes in the frame. It returns an action, or None where a choice is due; then
    :meth:`decision` lists the candidates and :meth:`choose` returns the action.

    Attributes:
        target: category of the target.
        map: the agent's map.
        planner: paths on it.
        strategy: lists the candidates.
        manner: options.
        decisions: how many choices were made.
    """

    _flat: ClassVar[frozenset[str]] = frozenset({"_plan", "_opened_at", "_stood", "_visited"})

    def __init__(self, info: Info, strategy: Strategy, manner: Manner | None = None, seed: int = 0) -> None:
        """Start an episode.

        Args:
            info: the info at the reset.
            strategy: a new object, used for this episode only.
            manner: options; defaults where None.
            seed: of random choices.
        """
        self.target = str(info["target"])
        self.map = SemanticMap.of(info)
        self.planner = Planner(info.get("nav"), self.map.body)
        self.strategy = strategy
        self.manner = manner or Manner()
        self.containers = Containers()
        self.homing = Homing()
        self.decisions = 0
        self._key = (seed, "waypoint", str(info.get("episode", "")))
        self._decision: Decision | None = None
        self._goal: View | None = None
        self._plan: deque[Action] = deque()
        self._walked = 0
        self._arrived = True
        self._turns = self.map.body.headings - 1 if self.manner.look_around else 0
        self._opened_at: set[View] = set()
        self._stood: set[View] = set()
        self._sent_to: int = -1
        self._visited: set[int] = set()
        self._taken: int | None = None

    @property
    def taking(self) -> bool:
        """Whether the target was found and the agent is walking up to it."""
        return self._taken is not None

    def look(self, observation: Mapping[str, Any], info: Info) -> Action | None:
        """Take in a frame.

        Args:
            observation: of the frame.
            info: of the frame.

        Returns:
            The next action, or None where a choice is due.
        """
        self._decision = None  # candidates from before this frame are out of date
        self.map.update(observation, info)
        self.strategy.look(self.map, observation, info)
        if self._arrived or not self._plan:
            self._stood.add(self.map.view)
        track = self._target_track()
        if track is not None and self._may_take(track):
            self._taken = track
            return self.homing.act(self.map, self.planner, track, blocked=bool(observation["collision"]))
        if bool(observation["collision"]) and self._goal is not None:
            walked = self._walked
            self.planner.update(self.map)
            self._walk_to(self._goal)
            self._walked = walked
        return self._next()

    def decision(self) -> Decision:
        """The choice that is due, computed once a frame. Only where :meth:`look` returned None.

        Where the strategy lists no candidate, a random explored node is the only one.
        """
        if self._decision is None:
            self.planner.update(self.map)
            draw = stream(*self._key, self.decisions)
            found = self._not_done(self.strategy.candidates(self.map, self.planner, draw)) or [self._random_node(draw)]
            around = tuple(self.strategy.sightings(self.map))
            self._decision = Decision(self.decisions, self.map.step, self.target, tuple(found), self.map, around, draw)
        return self._decision

    def _not_done(self, found: list[Candidate]) -> list[Candidate]:
        """The candidates, without poses where the agent stood and things it walked up to; directions always stay."""

        def done(c: Candidate) -> bool:
            return c.kind != "view" and (c.view in self._stood or c.track in self._visited)

        return [c for c in found if not done(c)]

    def choose(self, number: int) -> Action:
        """Make the choice that is due.

        Args:
            number: of the candidate in the decision.

        Returns:
            The first action towards it.
        """
        chosen = self.decision().candidates[number]
        self._decision = None
        self.decisions += 1
        if self.manner.interrupt == "chosen" and any(name == self.target for name, _ in chosen.things):
            track = self._target_track(chosen.view.heading)
            if track is not None:
                self._taken = track
                return self.homing.act(self.map, self.planner, track)
        self._sent_to = chosen.track
        self._walk_to(chosen.view)  # the planner was brought up to date for the decision
        first = self._next()
        # A choice without a walk must cost a step too, or repeating it would never end the episode.
        return Action.ROTATE_LEFT if first is None else first

    def _walk_to(self, view: View) -> None:
        """Plan a walk to a pose."""
        self._goal, self._plan = view, deque(self.planner.plan(view))
        self._walked, self._arrived = 0, False

    def _next(self) -> Action | None:
        """The next action of the walk, or on arrival Open, then rotations; None where a choice is due."""
        if self._plan:
            if 0 < self.manner.replan_steps <= self._walked:
                return None
            self._walked += 1
            return self._plan.popleft()
        if not self._arrived:
            self._arrived, self._goal = True, None
            if self._sent_to >= 0:
                self._visited.add(self._sent_to)
            self._turns = self.map.body.headings - 1 if self.manner.look_around else 0
        if self._opens_here():
            self._opened_at.add(self.map.view)
            return Action.OPEN
        if self._turns:
            self._turns -= 1
            return Action.ROTATE_LEFT
        return None

    def _opens_here(self) -> bool:
        """Whether to Open now: at most once a pose, where a closed container is within reach."""
        if not self.manner.opens or self.map.view in self._opened_at:
            return False
        return bool(self.containers.in_reach(self.map))

    def _may_take(self, track: int) -> bool:
        """Whether seeing the target, now or earlier, ends the search (:data:`Interrupt`)."""
        standing = self._arrived or not self._plan
        if self.manner.interrupt == "around" and standing and self.map.pixels[track] >= MIN_PIXELS:
            return True
        return self.taking or self.manner.interrupt == "always"

    def _target_track(self, heading: int | None = None) -> int | None:
        """The track of the target to go to, or None.

        The one chosen before, else one in view, else the nearest. With ``heading``, one in that direction comes first.
        There may be several, since a detector can be wrong.
        """
        known = self.map
        tracks = [t for t in known.instances.get(self.target, ()) if known.seen(t)]
        if self._taken is not None and known.category[self._taken] != self.target:
            self._taken = None  # it is something else after all
        if self._taken is not None or not tracks:
            return self._taken

        def order(track: int) -> tuple[bool, bool, float, int]:
            aside = heading is not None and _heading_to(known, track) != heading
            return aside, known.pixels[track] < MIN_PIXELS, known.gap_m(track, known.view.xy), track

        return min(tracks, key=order)

    def _random_node(self, draw: np.random.Generator) -> Candidate:
        """A random explored, reachable node at least 1 m away (any node, where there is none)."""
        i0, i1, j0, j1 = self.map.extent(0)
        window = (slice(i0, i1), slice(j0, j1))
        ok = (self.planner.steps[window].min(2) < UNREACHED) & (self.map.explored[window] > 0)
        nodes = np.argwhere(ok) + np.array([i0, j0])
        here = np.array([self.map.view.i, self.map.view.j])
        far = nodes[np.abs(nodes - here).sum(1) * CELL_M >= _WANDER_M]
        nodes = far if len(far) else nodes
        i, j = nodes[int(draw.integers(len(nodes)))].tolist()
        heading = int(self.planner.steps[i, j].argmin())
        view = View(i, j, heading, 0)
        return Candidate("wander", view, self.planner.cost(view))


def _heading_to(known: SemanticMap, track: int) -> int:
    """The heading in which a thing lies from where the agent stands."""
    x0, y0, _, x1, y1, _ = known.box[track]
    dx, dy = 0.5 * (x0 + x1) - known.view.xy[0], 0.5 * (y0 + y1) - known.view.xy[1]
    return heading_to(dx, dy, known.body.headings)
