"""A walk through the home before an episode: what someone who knows the home has seen, without the target.

Only privileged agents are given the tour (``info["privileged"]["tour"]``). It serves to measure what knowing the home
is worth.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.envs.frame import StartFrame
from ucon.perception.detectors import Detector, Frame
from ucon.task.search import Search

#: Nodes from one stop to the next along each axis: 1 m.
STRIDE: Final = 4
#: How many of a rule set's views are used at each stop: level, and down if the camera can pitch.
_VIEWS: Final = 2


@dataclass(frozen=True, eq=False)
class Tour:
    """Frames from all over the home, with its doors as they are; rendered when called.

    Attributes:
        search: the episode's search, at its start.
        renderer: has the home loaded.
        detector: names the things in the frames.
        frame: converts into the start frame.
        fov_deg: horizontal angle of view.
    """

    search: Search
    renderer: Any
    detector: Detector | None
    frame: StartFrame
    fov_deg: float

    def __call__(self) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        """Render the frames.

        Yields:
            Observation and info as :class:`ucon.perception.mapping.semantic_map.SemanticMap` takes them, without the
                target.

        Raises:
            ConfigError: there is no detector.
        """
        if self.detector is None:
            raise ConfigError("a tour of the home needs a detector; give the environment one, as detector=gt")
        start, rules = self.frame.start, self.search.rules
        for i, j in stops(self.search.world.free, (start.i, start.j)).tolist():
            x, y = self.search.world.house.grid.xy((i, j)).tolist()
            for yaw_deg in sorted((90 * start.heading + k * rules.turn_deg) % 360 for k in range(rules.headings)):
                for height, pitch_deg in rules.views[:_VIEWS]:
                    camera = (x, y, rules.camera_heights_m[height], yaw_deg / 90, pitch_deg)
                    yield self._look(camera, self.frame.place(i, j, yaw_deg, pitch_deg), self.detector)

    def _look(
        self, camera: tuple[float, float, float, float, int], pose: NDArray[np.float32], detector: Detector
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Observation and info of one frame, without the target."""
        height, width, target = self.renderer.height, self.renderer.width, self.search.target
        depth, instance = np.empty((height, width), np.float32), np.empty((height, width), np.int16)
        rgb = np.empty((height, width, 3), np.uint8) if detector.needs_rgb else None
        counts = np.empty(len(self.search.world.boxes), np.int32)
        self.renderer.render(*camera, rgb=rgb, depth=depth, instance=instance, counts=counts)
        hide(target, instance, counts)
        camera_m = camera[2]
        found = detector.detect(
            Frame(depth, rgb, pose, camera_m, self.fov_deg, instance, counts, self.search.rules.fov_deg)
        )
        info = {"camera_m": camera_m, "depth": depth, "detections": found, "tracks": found.image}
        return {"pose": pose, "collision": np.zeros(1, np.int8)}, info


def hide(target: int, instance: NDArray[np.int16] | None, counts: NDArray[np.int32] | None) -> None:
    """Take an instance out of a frame, so that detectors that use instances miss it; it stays in image and depth.

    Args:
        target: number of the instance.
        instance: (H, W) int16, updated.
        counts: pixels of every instance, updated.
    """
    if instance is not None:
        instance[instance == target] = -1
    if counts is not None:
        counts[target] = 0


def stops(free: NDArray[np.bool_], start: tuple[int, int]) -> NDArray[np.int64]:
    """Nodes 1 m apart that can be reached from the start.

    Args:
        free: (nx, ny) bool.
        start: node of the agent.

    Returns:
        (n, 2) int64, by row.
    """
    _, number = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    reached = number == number[start]
    grid = np.zeros_like(reached)
    grid[start[0] % STRIDE :: STRIDE, start[1] % STRIDE :: STRIDE] = True
    return np.argwhere(reached & grid)
