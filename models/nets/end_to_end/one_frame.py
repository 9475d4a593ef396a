"""Arrays of one step of the environment, as the end-to-end habit policy reads and stores them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from models.nets.end_to_end.ego_view import N_THINGS, ego_view
from models.nets.end_to_end.read_habits import words
from models.nets.vision.eye import small_image
from ucon.core.errors import ConfigError
from ucon.learning.policies.action_policy import Arrays
from ucon.task.actions import decoded_action

#: Positions are rounded to cells of this side; looks up or down are in units of these degrees.
_CELL_M, _LOOK_DEG = 0.25, 30


def one_frame(observation: Mapping[str, Any], info: Mapping[str, Any], image_px: int, *, with_rgb: bool) -> Arrays:
    """Image, patch of floor, things and status of one step; about 20 kB.

    Args:
        observation: of ``UcON-v0``, with ``rgb`` and ``depth``.
        info: of the same step, with detections.
        image_px: side of the stored image; divides the camera's.
        with_rgb: store the whole frame too, as ``rgb``.

    Returns:
        ``image`` (4, px, px) uint8; ``pose`` (4,) int16: cell (i, j), heading, look; ``status`` (3,) int16: step,
        collision, last action; and the arrays of :class:`models.nets.end_to_end.ego_view.EgoView`.

    Raises:
        ConfigError: images or detections are missing, or ``image_px`` does not fit.
    """
    if "rgb" not in observation or "depth" not in observation:
        raise ConfigError("agent habit_policy_e2e: observations without images; give env.observe=pixels")
    if "detections" not in info:
        raise ConfigError("agent habit_policy_e2e: no detections; give the environment a detector, such as detector=gt")
    depth = observation["depth"].reshape(observation["depth"].shape[:2])
    if depth.shape[0] % image_px or depth.shape[1] % image_px:
        sides = " x ".join(map(str, depth.shape))
        raise ConfigError(f"agent.policy.image_px={image_px}: must divide the camera's {sides} pixels")
    x, y, yaw, pitch = (float(v) for v in observation["pose"])
    view = ego_view(depth, pitch, float(info["camera_m"]), info, str(info["target"]))
    number = words().number
    ids = np.full(N_THINGS, -1, np.int16)
    ids[: len(view.names)] = [number.get(name, len(number)) for name in view.names]
    look = int(np.clip(round(np.degrees(pitch) / _LOOK_DEG), -2, 2))
    pose = [round(x / _CELL_M), round(y / _CELL_M), round(yaw / (np.pi / 2)) % 4, look]
    status = [observation["step"][0], observation["collision"][0], decoded_action(observation["last_action"])]
    frame: Arrays = {
        "image": small_image(observation["rgb"], depth, image_px),
        "pose": np.array(pose, np.int16),
        "status": np.array(status, np.int16),
        "patch": view.patch,
        "look": view.look,
        "thing_ids": ids,
        "thing_tracks": view.tracks,
        "things": view.things,
        "pair_cell": view.pair_cell,
        "pair_row": view.pair_row,
    }
    return {**frame, **({"rgb": observation["rgb"]} if with_rgb else {})}
