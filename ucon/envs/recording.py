"""Videos by Gymnasium's ``RecordVideo``, with all frames that a step gives."""

from __future__ import annotations

from typing import Any

import gymnasium as gym


class RecordVideo(gym.wrappers.RecordVideo):
    """Records every frame of an environment whose ``render_mode`` is ``rgb_array_list``.

    Gymnasium's own keeps the last one of each step: of a choice, which takes many actions, only where it led to.
    """

    def _capture_frame(self) -> None:
        frames: Any = self.env.render()
        self.recorded_frames.extend(frames if isinstance(frames, list) else [frames])
