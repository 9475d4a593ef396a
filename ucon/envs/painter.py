"""Frames for people: the camera's image with the map of the home beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ucon.core.sharing import Shared
from ucon.envs.topdown import TopDownMap
from ucon.sim.render import RasterRenderer
from ucon.task.ledger import Ledger
from ucon.task.search import Pose, Search

FRAME_PX: Final = 384


@dataclass(frozen=True)
class Moment(Shared):
    """The state that a frame shows; stored at each step and drawn on demand."""

    pose: Pose
    """The agent's pose."""
    opened: tuple[int, ...]
    """Opened instances, ascending."""
    nodes: int
    """Number of nodes of the path so far."""

    @classmethod
    def of(cls, search: Search, ledger: Ledger) -> Moment:
        """The current state of a search."""
        return cls(search.pose, tuple(np.flatnonzero(search.opened).tolist()), len(ledger.path_xy))


class Painter:
    """Draws the moments of one episode. The home is loaded once; containers are opened as they were in the episode."""

    def __init__(self, search: Search, ledger: Ledger) -> None:
        """Load the home.

        Args:
            search: the episode's search.
            ledger: has the path so far.
        """
        self._renderer = RasterRenderer(FRAME_PX, FRAME_PX, search.rules.fov_deg)
        self._search, self._ledger = search, ledger
        world: Any = search.world
        heading = ledger.episode.start.heading
        self._map = TopDownMap(world.house, world.boxes, world.free, FRAME_PX, heading)
        self._shown: set[int] = set()
        self._renderer.load(world.house, world.arrangement)

    def draw(self, moment: Moment) -> NDArray[np.uint8]:
        """Draw a moment of this episode.

        Returns:
            The camera's image and the top-down map beside it, (384, 768, 3) uint8.
        """
        world: Any = self._search.world
        if not self._shown.issubset(moment.opened):  # an earlier moment: close everything first
            self._renderer.load(world.house, world.arrangement)
            self._shown = set()
        for instance in moment.opened:
            if instance not in self._shown:
                self._renderer.set_open(instance, 1.0)
        self._shown = set(moment.opened)
        frame = np.empty((FRAME_PX, 2 * FRAME_PX, 3), np.uint8)
        camera = np.empty((FRAME_PX, FRAME_PX, 3), np.uint8)
        rules, path = self._search.rules, self._ledger.path_xy[: moment.nodes]
        height_m = rules.camera_heights_m[moment.pose.height]
        self._renderer.render(*path[-1], height_m, moment.pose.heading, moment.pose.pitch_deg, rgb=camera)
        frame[:, :FRAME_PX] = camera
        boxes = world.boxes
        frame[:, FRAME_PX:] = self._map.draw(
            path, moment.pose.heading, boxes[self._search.target], boxes[list(moment.opened)]
        )
        return frame
