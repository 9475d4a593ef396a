"""The interface of renderers, and the canonical view in which pixels are counted."""

from __future__ import annotations

import math
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ucon.core.errors import ConfigError
from ucon.core.geometry import HEADING_COS, HEADING_SIN
from ucon.sim.arrangement import Arrangement
from ucon.sim.house import House

VIEW_PX: Final = 128
VIEW_FOV_DEG: Final = 90.0
"""The canonical view: pixels are counted at this size and, unless the rules set another, this angle."""

SKY: Final = -1
"""Instance number of pixels that show nothing."""
SKY_DEPTH_M: Final = 100.0

_PITCH = {
    0: (1.0, 0.0),
    30: (math.sqrt(0.75), 0.5),
    60: (0.5, math.sqrt(0.75)),
}


class Renderer(Protocol):
    """Renders first-person images of a home in an episode.

    Camera: position in metres; ``heading`` in quarter turns counter-clockwise, 0 looks along +x (fractions are allowed,
    for continuous motion); ``pitch_deg`` is positive upwards. Pixels are square.

    Attributes:
        width: of images, pixels.
        height: of images, pixels.
        fov_deg: horizontal angle of view.
    """

    width: int
    height: int
    fov_deg: float

    @property
    def n_instances(self) -> int:
        """Number of instances of the home and objects of the episode."""

    def close(self) -> None:
        """Release what the renderer holds."""

    def load(self, house: House, arrangement: Arrangement | None = None) -> None:
        """Load a home with an arrangement, everything closed."""

    def set_open(self, instance: int, fraction: float) -> None:
        """Open all joints of an instance, with what its drawers hold.

        Args:
            instance: its number.
            fraction: of the travel, 0 to 1.
        """

    def render(
        self,
        x: float,
        y: float,
        z: float,
        heading: float,
        pitch_deg: float,
        rgb: NDArray[np.uint8] | None = None,
        depth: NDArray[np.float32] | None = None,
        instance: NDArray[np.int16] | None = None,
        counts: NDArray[np.int32] | None = None,
    ) -> None:
        """Render into the caller's buffers; each may be None.

        Args:
            x: of the camera, world metres.
            y: of the camera.
            z: of the camera.
            heading: quarter turns.
            pitch_deg: degrees, up positive.
            rgb: (H, W, 3) uint8.
            depth: (H, W) float32, metres along the optical axis; ``SKY_DEPTH_M`` where there is nothing.
            instance: (H, W) int16 instance numbers; ``SKY`` where there is nothing.
            counts: (n_instances,) int32, as :meth:`visible`; costs nothing if the image is the canonical view.

        Raises:
            ConfigError: a buffer has the wrong shape, type or layout.
        """

    def visible(
        self,
        x: float,
        y: float,
        z: float,
        heading: float,
        pitch_deg: float,
        counts: NDArray[np.int32] | None = None,
    ) -> NDArray[np.int32]:
        """Pixels of every instance in the canonical view (128 x 128, 90 degrees unless the rules say otherwise).

        Args:
            x: of the camera, world metres.
            y: of the camera.
            z: of the camera.
            heading: quarter turns.
            pitch_deg: degrees, up positive.
            counts: (n_instances,) int32 buffer to write to; a new one if None.

        Returns:
            (n_instances,) int32.
        """


def heading_cos_sin(heading: float) -> tuple[float, float]:
    """Cosine and sine of a heading in quarter turns, exact for whole ones."""
    whole = int(heading)
    if whole == heading:
        return HEADING_COS[whole % 4], HEADING_SIN[whole % 4]
    return math.cos(heading * math.pi / 2), math.sin(heading * math.pi / 2)


def pitch_cos_sin(pitch_deg: float) -> tuple[float, float]:
    """Cosine and sine of a pitch in degrees, from a table for 0, 30 and 60."""
    known = _PITCH.get(abs(pitch_deg))  # type: ignore[call-overload]
    if known is None:
        return math.cos(math.radians(pitch_deg)), math.sin(math.radians(pitch_deg))
    return known[0], known[1] if pitch_deg >= 0 else -known[1]


def tan_half(fov_deg: float) -> float:
    """Tangent of half the angle of view, exactly 1 for 90 degrees."""
    return 1.0 if fov_deg == 90.0 else math.tan(math.radians(fov_deg) / 2)


def check_view(width: int, height: int, fov_deg: float) -> None:
    """Check size and angle of an image.

    Raises:
        ConfigError: out of range.
    """
    if not (1 <= width <= 4096 and 1 <= height <= 4096):
        raise ConfigError(f"picture of {width} x {height} pixels: expected 1 to 4096 a side")
    if not 1.0 <= fov_deg <= 170.0:
        raise ConfigError(f"field of view of {fov_deg} degrees: expected 1 to 170")


def check_buffer(name: str, array: np.ndarray, shape: tuple[int, ...], dtype: type[np.generic]) -> None:
    """Check that kernels can write a buffer.

    Args:
        name: for errors.
        array: the buffer.
        shape: expected shape.
        dtype: expected type.

    Raises:
        ConfigError: wrong shape, type or memory layout.
    """
    if array.shape != shape or array.dtype != dtype or not array.flags.c_contiguous:
        raise ConfigError(
            f"{name} buffer is {array.dtype} {array.shape}{'' if array.flags.c_contiguous else ', not contiguous'}: "
            f"expected a C-contiguous {np.dtype(dtype)} array of shape {shape}"
        )
