"""Gymnasium's ``RecordVideo`` with all frames of a step."""

from __future__ import annotations

from typing import Any

import gymnasium as gym


class RecordVideo(gym.wrappers.RecordVideo):
    """Records every frame of an environment whose ``render_mode`` is ``rgb_array_list``.

    Gymnasium's own class keeps the last frame of each step. A step of ``UcONSearch-v0`` takes many actions.
    """

    def _capture_frame(self) -> None:
        """Append all frames since the last call."""
        frames: Any = self.env.render()
        self.recorded_frames.extend(frames if isinstance(frames, list) else [frames])
