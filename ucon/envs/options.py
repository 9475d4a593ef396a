"""Checks of an environment's options and actions; makes renderers and detectors from options."""

from __future__ import annotations

from multiprocessing import current_process
from operator import index
from typing import Any

import numpy as np

from ucon.core.errors import ActionError, ConfigError, brief
from ucon.perception.detectors import Detector, GtDetector
from ucon.sim.render import RasterRenderer, Renderer
from ucon.sim.render.base import VIEW_FOV_DEG


def check_choice(option: str, value: Any, choices: tuple[Any, ...]) -> None:
    """Check that an option has one of its values.

    Raises:
        ConfigError: the value is not among ``choices``; ``option`` names the option.
    """
    if value not in choices:
        raise ConfigError(f"{option}={value!r}: expected one of {', '.join(map(str, choices))}")


def check_render_mode(value: Any, modes: tuple[str, ...] | list[str]) -> None:
    """Check a ``render_mode``; None is always allowed.

    Raises:
        ConfigError: the value is not in ``modes``. For ``human`` the message says what to do instead.
    """
    if value == "human":
        raise ConfigError(
            "render_mode='human': no window is opened; give render_mode='rgb_array' and show what render() returns, or "
            "film a run (python -m ucon watch RUN EPISODE)"
        )
    check_choice("render_mode", value, (None, *modes))


def make_renderer(
    name: str, width_px: int, height_px: int, fov_deg: float, counting_fov_deg: float = VIEW_FOV_DEG
) -> Renderer:
    """Make a renderer.

    Args:
        name: ``raster``, or ``tiny`` (PyBullet's).
        width_px: width of its images.
        height_px: height of its images.
        fov_deg: horizontal angle of view.
        counting_fov_deg: angle of the view in which the rules count pixels.

    Raises:
        ConfigError: an unknown name.
    """
    check_choice("renderer", name, ("raster", "tiny"))
    if name == "raster":
        return RasterRenderer(width_px, height_px, fov_deg, counting_fov_deg=counting_fov_deg)
    from ucon.sim.render.tiny import TinyRenderer  # the only renderer that needs PyBullet

    return TinyRenderer(width_px, height_px, fov_deg, counting_fov_deg=counting_fov_deg)


def make_detector(option: bool | Detector | None) -> Detector | None:
    """The detector that an option stands for.

    Args:
        option: False or None for none, True for ``gt``, or a detector. A detector follows the episode of one
            environment: do not share it between two.

    Raises:
        ConfigError: the value is not a detector.
    """
    if option is None or isinstance(option, bool):
        return GtDetector() if option else None
    if not callable(getattr(option, "detect", None)):
        raise ConfigError(f"detector={option!r}: expected true (gt), false, or a detector; see configs/detector/")
    return option


def checked_action(action: Any, n: int) -> int:
    """An action as a number below ``n``.

    Args:
        action: what was given to ``step``.
        n: number of actions.

    Raises:
        ActionError: not an integer (1.0 and True are refused), or out of range.
    """
    try:
        number = index(action)
    except TypeError:
        number = -1
    if not 0 <= number < n or isinstance(action, bool):
        raise ActionError(f"action={brief(action)}: expected a whole number from 0 to {n - 1}")
    return number


def with_texts(texts: bool | None) -> bool:
    """Whether infos hold texts: as the option says; None: yes, except in workers of ``AsyncVectorEnv``.

    TorchRL's ``GymEnv(name, num_envs=2)`` makes such workers, and converts everything in their infos to tensors.
    """
    return texts if texts is not None else not current_process().name.startswith("Worker<")  # Gymnasium's name


def returned_info(info: dict[str, Any], *, texts: bool) -> dict[str, Any]:
    """An info in the form in which an environment returns it.

    Args:
        info: the full info.
        texts: False keeps numbers and arrays only, and adds ``is_success``. TorchRL makes tensors of the infos of
            vector environments and needs the same keys at all steps.
    """
    if texts:
        return info
    numbers = {name: v for name, v in info.items() if isinstance(v, int | float | np.ndarray | np.generic)}
    return {"is_success": False, **numbers}
