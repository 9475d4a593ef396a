"""What is given to an environment, checked: one of several names, a renderer, a detector, an action."""

from __future__ import annotations

from multiprocessing import current_process
from operator import index
from typing import Any

import numpy as np

from ucon.core.errors import ActionError, ConfigError, brief
from ucon.perception.detectors import Detector, GtDetector
from ucon.sim.render import RasterRenderer, Renderer


def check_choice(option: str, value: Any, choices: tuple[Any, ...]) -> None:
    """Raise :class:`ConfigError` where ``value`` is none of ``choices``."""
    if value not in choices:
        raise ConfigError(f"{option}={value!r}: expected one of {', '.join(map(str, choices))}")


def check_render_mode(value: Any, modes: tuple[str, ...] | list[str]) -> None:
    """Raise :class:`ConfigError` where ``value`` is none of ``modes`` and not None."""
    if value == "human":
        raise ConfigError(
            "render_mode='human': no window is opened; give render_mode='rgb_array' and show what render() returns, or "
            "film a run (python -m ucon watch RUN EPISODE)"
        )
    check_choice("render_mode", value, (None, *modes))


def make_renderer(name: str, width_px: int, height_px: int, fov_deg: float) -> Renderer:
    """The renderer of a name: ``raster`` or ``tiny``."""
    check_choice("renderer", name, ("raster", "tiny"))
    if name == "raster":
        return RasterRenderer(width_px, height_px, fov_deg)
    from ucon.sim.render.tiny import TinyRenderer  # PyBullet is needed for it, and for nothing else here

    return TinyRenderer(width_px, height_px, fov_deg)


def make_detector(option: bool | Detector | None) -> Detector | None:
    """The detector of an option: none for False and None, ``gt`` for True, an object as it is.

    An object follows the episode of one environment: it must not be given to two.
    """
    if option is None or isinstance(option, bool):
        return GtDetector() if option else None
    if not callable(getattr(option, "detect", None)):
        raise ConfigError(f"detector={option!r}: expected true (gt), false, or a detector; see configs/detector/")
    return option


def checked_action(action: Any, n: int) -> int:
    """An action as a number below ``n``.

    Raises:
        ActionError: no whole number (1.0 is none), or out of range.
    """
    try:
        number = index(action)
    except TypeError:
        number = -1
    if not 0 <= number < n or isinstance(action, bool):
        raise ActionError(f"action={brief(action)}: expected a whole number from 0 to {n - 1}")
    return number


def with_texts(texts: bool | None) -> bool:
    """Whether infos hold texts: as asked for, else everywhere but in worker processes of ``AsyncVectorEnv``.

    TorchRL's ``GymEnv(name, num_envs=2)`` makes such workers, and tensors of whatever stands in their infos.
    """
    return texts if texts is not None else not current_process().name.startswith("Worker<")  # Gymnasium's name


def told(info: dict[str, Any], *, texts: bool) -> dict[str, Any]:
    """An info as an environment gives it; without ``texts`` numbers and arrays alone.

    TorchRL makes tensors of the infos of vector environments, by the names of observations, the same ones at all steps.
    """
    if texts:
        return info
    numbers = {name: v for name, v in info.items() if isinstance(v, int | float | np.ndarray | np.generic)}
    return {"is_success": False, **numbers}
