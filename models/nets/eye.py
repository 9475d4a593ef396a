"""A small visual encoder: colours and depth of one frame to a vector. Small, because it must train on a CPU."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

FARTHEST_M = 10.0


def small_image(rgb: NDArray[np.uint8], depth: NDArray[np.float32], size: int) -> NDArray[np.uint8]:
    """Colours and depth as (4, size, size) uint8: means of colours, least of depths (0 to 10 m as 0 to 255).

    ``rgb`` (H, W, 3) and ``depth`` (H, W) metres; H and W are multiples of ``size``.
    """
    height, width = depth.shape
    blocks = (size, height // size, size, width // size)
    colours = rgb.reshape(*blocks, 3).mean((1, 3), dtype=np.float32)
    near = depth.reshape(blocks).min((1, 3))
    out = np.empty((4, size, size), np.uint8)
    out[:3] = colours.transpose(2, 0, 1)
    out[3] = np.clip(near, 0.0, FARTHEST_M) * (255.0 / FARTHEST_M)
    return out


class Eye(nn.Module):
    """Four convolutions."""

    def __init__(self, size: int, out: int) -> None:
        """``size``: pixels of a side of the image, a multiple of 16; ``out``: length of the vector."""
        super().__init__()
        widths = (4, 16, 32, 48, 48)
        layers: list[Any] = []
        for k, (a, b) in enumerate(pairwise(widths)):
            layers += [nn.Conv2d(a, b, 5 if k == 0 else 3, stride=2, padding=2 if k == 0 else 1), nn.GroupNorm(8, b)]
            layers += [nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Flatten(), nn.Linear(widths[-1] * (size // 16) ** 2, out), nn.ReLU())

    def forward(self, image: Tensor) -> Tensor:
        """(N, 4, size, size) uint8 to (N, out)."""
        return self.layers(image.to(torch.get_default_dtype()) / 127.5 - 1.0)  # type: ignore[no-any-return]
