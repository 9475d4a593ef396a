"""The input of a detector (:class:`Frame`), its interface (:class:`Detector`), and the names it looks for.

Every detector looks for all categories of the catalogue. A list of the categories of one home or episode would reveal
to the agent what is there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.objects.catalogue import catalogue
from ucon.perception.mapping.detections import STRUCTURE_KINDS, Detections

#: A yaw this near to a quarter turn counts as one, since poses have single precision.
_EXACT_RAD: Final = 1e-6


@dataclass(frozen=True, slots=True)
class Frame:
    """What the agent sees at one step.

    ``instance`` and ``counts`` are the simulator's truth: no real detector may read them.
    """

    depth: NDArray[np.float32]
    """(H, W) metres along the optical axis, 0 where there is none."""
    rgb: NDArray[np.uint8] | None
    """(H, W, 3); None unless the detector's ``needs_rgb`` is True."""
    pose: NDArray[np.float32]
    """(4,) x, y in metres, yaw, pitch (up positive) in radians, in the agent's start frame."""
    camera_m: float
    """Height of the camera above the floor."""
    fov_deg: float
    """Horizontal angle of view; pixels are square."""
    instance: NDArray[np.int16]
    """(H, W) the simulator's instance of every pixel, -1 where there is none."""
    counts: NDArray[np.int32]
    """(n_instances,) pixels of each instance in the rules' canonical view of 128 x 128 from the same pose."""
    counts_fov_deg: float = 90.0
    """Angle of the canonical view."""

    @property
    def camera(self) -> NDArray[np.float64]:
        """(8,) float64, the camera as the map kernels take it.

        x, y, z in metres in the agent's start frame, cos yaw, sin yaw, cos pitch, sin pitch, focal length in pixels.
        Cosine and sine of quarter turns are exact.
        """
        x, y, yaw, pitch = (float(v) for v in self.pose)
        quarter = round(yaw / (np.pi / 2))
        focal_px = 0.5 * self.depth.shape[1] / np.tan(np.deg2rad(self.fov_deg) / 2)
        whole = abs(yaw - quarter * np.pi / 2) < _EXACT_RAD
        heading = (HEADING_COS[quarter % 4], HEADING_SIN[quarter % 4]) if whole else (np.cos(yaw), np.sin(yaw))
        return np.array([x, y, self.camera_m, *heading, np.cos(pitch), np.sin(pitch), focal_px])


class Detector(Protocol):
    """Finds things in frames and follows them through one episode.

    A detector with weights also has ``check()`` and ``fingerprint()``, see
    :mod:`ucon.evaluation.playing.needed_weights`. One that errs gives scores, and has ``errors``: a
    :class:`ucon.perception.errors.model.DetectorErrors`, or None where they are not known.
    """

    name: str
    needs_rgb: bool
    """Whether :attr:`Frame.rgb` must be there."""

    def reset(self, episode: str, categories: tuple[str, ...]) -> None:
        """Start an episode: forget all tracks.

        Args:
            episode: id of the episode; the key of random draws.
            categories: category of every instance of the simulator, for simulated detectors only.
        """

    def detect(self, frame: Frame) -> Detections:
        """Find and track the things in the next frame of the episode.

        Returns:
            One row for each track in view, and the track of every pixel.

        Raises:
            DetectorError: a detector with weights cannot be loaded or run.
        """

    def tracks_of(self, instances: tuple[int, ...]) -> tuple[int, ...]:
        """Tracks that stand for some of the simulator's instances (those that an Open opened).

        The environment's bookkeeping: instances that were never seen are left out.
        """

    def close(self) -> None:
        """Release what the detector holds (models, processes)."""


@lru_cache(maxsize=1)
def vocabulary() -> tuple[str, ...]:
    """The names that detectors look for: all categories of the catalogue, in its order.

    Floors, walls and ceilings are left out: they are recognised by geometry.
    """
    return tuple(name for name in catalogue().names if name not in STRUCTURE_KINDS)
