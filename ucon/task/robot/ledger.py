"""The running metrics of an episode with a robot that moves continuously."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from ucon.sim.render.base import heading_cos_sin
from ucon.sim.robot.field import Field, PathGrid
from ucon.task.actions import Action
from ucon.task.episode import Episode
from ucon.task.ledger import Ledger
from ucon.task.robot.search import MOVE_M, RobotSearch
from ucon.task.rules import task_rules

Point = tuple[float, float]


class RobotLedger(Ledger):
    """Like :class:`ucon.task.ledger.Ledger`, with the metres actually moved and the body's own shortest paths."""

    _shared: ClassVar[frozenset[str]] = Ledger._shared | {"_grid"}
    _flat: ClassVar[frozenset[str]] = frozenset({"path_xy", "_ways"})
    search: RobotSearch

    def to_goal_m(self) -> float:
        """Path length in metres via the place of the stored solution's Open to its last place.

        Once the target's container is open, or if there is none, the length to the last place alone.
        """
        if self._opens_at is None or self.search.opened[self.episode.target_object.holder]:
            return self._way_from(self._ends_at).at(*self.search.xy)
        to_open = self._way_from(self._opens_at)
        return to_open.at(*self.search.xy) + to_open.at(*self._ends_at)

    def _set_goals(self) -> None:
        """Set the places that distances are measured to."""
        self._opens_at, self._ends_at = solution_places(self.episode, self.search.xy)
        self._ways: dict[Point, Field] = {}

    def _moved_m(self) -> float:
        """Metres moved so far."""
        return self.search.moved_m

    def _start_and_final_m(self) -> tuple[float, float]:
        """Path lengths in metres from the start and from here to the last place of the stored solution."""
        way = self._way_from(self._ends_at)
        return way.at(*self.path_xy[0]), way.at(*self.search.xy)

    def _way_from(self, place: Point) -> Field:
        """Shortest paths from a place; computed once."""
        if place not in self._ways:
            self._ways[place] = self._grid.field(*place)
        return self._ways[place]

    @cached_property
    def _grid(self) -> PathGrid:
        """Grid of where the robot can be; made when a distance is first needed."""
        return PathGrid(self.search.floor)


def solution_places(episode: Episode, start: Point) -> tuple[Point | None, Point]:
    """Places of an episode's stored solution, executed without errors under the rules it was made for.

    Args:
        episode: the episode.
        start: position of the robot at the start, world metres.

    Returns:
        The place of its Open (None without one), and its last place.
    """
    (x, y), yaw_deg, turn_deg = start, 90.0 * episode.start.heading, task_rules(episode.task).turn_deg
    opening = None
    for digit in map(int, episode.solution):
        if digit == Action.MOVE_AHEAD:
            c, s = heading_cos_sin(yaw_deg / 90.0)
            x, y = x + c * MOVE_M, y + s * MOVE_M
        elif digit in (Action.ROTATE_LEFT, Action.ROTATE_RIGHT):
            yaw_deg = (yaw_deg + (turn_deg if digit == Action.ROTATE_LEFT else -turn_deg)) % 360.0
        elif digit == Action.OPEN:
            opening = (x, y)
    return opening, (x, y)
