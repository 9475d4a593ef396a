"""What a detector is shown, and what it must offer.

The vocabulary of every detector is the catalogue: never the categories of one home or episode, which would tell what
is there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.detections import STRUCTURE_KINDS, Detections


@dataclass(frozen=True, slots=True)
class Frame:
    """One look of the agent. The last two fields are the simulator's truth, which no real detector may read."""

    depth: NDArray[np.float32]
    """(H, W) metres along the optical axis."""
    rgb: NDArray[np.uint8] | None
    """(H, W, 3), only for detectors that need it."""
    pose: NDArray[np.float32]
    """(4,) x, y in metres, yaw, pitch (up positive) in radians, in the agent's start frame."""
    camera_m: float
    """Height of the camera above the floor."""
    fov_deg: float
    """Horizontal angle of view; pixels are square."""
    instance: NDArray[np.int16]
    """(H, W) instance of every pixel, -1 where there is none."""
    counts: NDArray[np.int32]
    """(n_instances,) pixels of each in the canonical 128 x 128 view from the same pose."""

    @property
    def camera(self) -> NDArray[np.float64]:
        """The map kernels' camera (8,); headings are quarter turns, so their cosines are exact."""
        x, y, yaw, pitch = (float(v) for v in self.pose)
        quarter = round(yaw / (np.pi / 2))
        focal_px = 0.5 * self.depth.shape[1] / np.tan(np.deg2rad(self.fov_deg) / 2)
        heading = HEADING_COS[quarter % 4], HEADING_SIN[quarter % 4]
        return np.array([x, y, self.camera_m, *heading, np.cos(pitch), np.sin(pitch), focal_px])


class Detector(Protocol):
    """Finds things in frames and follows them through one episode.

    One with weights has ``check()`` and ``fingerprint()`` besides, see :mod:`ucon.evaluation.playing.needed_weights`.
    """

    name: str
    needs_rgb: bool
    """Whether :attr:`Frame.rgb` must be there."""

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Forget everything. ``episode`` keys random draws; ``categories`` of all instances are for simulated ones."""

    def detect(self, frame: Frame) -> Detections:
        """What is seen in the next frame of the episode."""

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks that stand for instances (those that an Open opened); unseen ones are left out."""

    def close(self) -> None:
        """Release what the detector holds."""


@lru_cache(maxsize=1)
def vocabulary() -> tuple[str, ...]:
    """Names that detectors are asked for: the catalogue without pieces of the building, which geometry tells."""
    return tuple(name for name in catalogue().names if name not in STRUCTURE_KINDS)
