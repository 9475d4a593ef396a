"""The running metrics of an episode, and the distance used by the progress reward."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import PartlyShared
from ucon.scenes.spec import GRID_M
from ucon.sim.paths import distances
from ucon.task.actions import AHEAD, Action
from ucon.task.episode import Episode
from ucon.task.outcome import EpisodeOutcome
from ucon.task.search import Search, StepOutcome


class Ledger(PartlyShared):
    """The running metrics of one episode.

    Attributes:
        episode: the episode.
        search: its running search.
        steps: actions so far.
        moves: MoveAhead actions that were not blocked.
        opens: Open actions.
        collisions: blocked MoveAhead actions.
        first_seen_step: step after which the target was first visible; -1: not yet.
        in_reach: whether Done would have succeeded at some step.
        stopped: whether Done was called.
        success: whether Done succeeded.
        path_xy: positions along the path, metres in the world frame.
    """

    _shared: ClassVar[frozenset[str]] = frozenset({"episode"})
    _flat: ClassVar[frozenset[str]] = frozenset({"path_xy", "_fields"})

    def __init__(self, episode: Episode, search: Search) -> None:
        """Start counting.

        Args:
            episode: the episode.
            search: its search, before the first step.
        """
        self.episode, self.search = episode, search
        self.steps = self.moves = self.opens = self.collisions = 0
        self.first_seen_step = -1
        self.in_reach = self.stopped = self.success = False
        self.path_xy = [search.xy]
        self._set_goals()
        self._note_target()

    def _set_goals(self) -> None:
        """Set the nodes that distances are measured to."""
        self._opening, self._end = solution_nodes(self.episode)
        self._fields: dict[tuple[int, int], NDArray[np.int32]] = {}

    def note(self, action: int, outcome: StepOutcome) -> None:
        """Count a step that the search has just taken.

        Args:
            action: the action taken.
            outcome: its effect, as the search returned it.
        """
        self.steps += 1
        self.collisions += outcome.collision
        self.opens += action == Action.OPEN
        self.stopped, self.success = outcome.done, outcome.success
        self.moves += action == Action.MOVE_AHEAD and not outcome.collision
        if self.search.xy != self.path_xy[-1]:
            self.path_xy.append(self.search.xy)
        self._note_target()

    def to_goal_m(self) -> float:
        """Path length in metres via the node of the stored solution's Open to its last node.

        Once the target's container is open, or if there is none, the length to the last node alone.
        """
        here = (self.search.pose.i, self.search.pose.j)
        holder = self.episode.target_object.holder
        if self._opening is None or self.search.opened[holder]:
            return float(self._field(self._end)[here]) * GRID_M
        return float(self._field(self._opening)[here] + self._field(self._end)[self._opening]) * GRID_M

    def outcome(self) -> EpisodeOutcome:
        """The metrics so far."""
        target = self.episode.target_object
        contained = target.holder >= 0 and bool(self.search.world.openable[target.holder])
        start_m, final_m = self._start_and_final_m()
        return EpisodeOutcome(
            success=self.success,
            steps=self.steps,
            path_length_m=self._moved_m(),
            shortest_path_m=self.episode.shortest_path_m,
            final_distance_m=final_m,
            start_distance_m=start_m,
            opens=self.opens,
            containers_opened=int(self.search.opened.sum()),
            collisions=self.collisions,
            first_seen_step=self.first_seen_step,
            stopped=self.stopped,
            in_reach=self.in_reach,
            contained=contained,
            container_opened=contained and bool(self.search.opened[target.holder]),
        )

    def _moved_m(self) -> float:
        """Metres moved so far."""
        return self.moves * GRID_M

    def _start_and_final_m(self) -> tuple[float, float]:
        """Path lengths in metres from the start and from here to the last node of the stored solution."""
        start, pose, field = self.episode.start, self.search.pose, self._field(self._end)
        return float(field[start.i, start.j]) * GRID_M, float(field[pose.i, pose.j]) * GRID_M

    def _note_target(self) -> None:
        """Note whether the target is visible and within reach now."""
        if self.search.target_visible():
            if self.first_seen_step < 0:
                self.first_seen_step = self.steps
            self.in_reach = self.in_reach or self.search.target_in_reach()

    def _field(self, node: tuple[int, int]) -> NDArray[np.int32]:
        """Moves from every node to a node, (nx, ny) int32; computed once."""
        if node not in self._fields:
            self._fields[node] = distances(self.search.world.free, [node])
        return self._fields[node]


def solution_nodes(episode: Episode) -> tuple[tuple[int, int] | None, tuple[int, int]]:
    """Nodes of an episode's stored solution.

    Returns:
        The node of its Open (None without one), and its last node.
    """
    i, j, heading = episode.start.i, episode.start.j, episode.start.heading
    opening = None
    for digit in map(int, episode.solution):
        if digit == Action.MOVE_AHEAD:
            i, j = i + AHEAD[heading][0], j + AHEAD[heading][1]
        elif digit == Action.ROTATE_LEFT:
            heading = (heading + 1) % 4
        elif digit == Action.ROTATE_RIGHT:
            heading = (heading + 3) % 4
        elif digit == Action.OPEN:
            opening = (i, j)
    return opening, (i, j)
