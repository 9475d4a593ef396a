"""A small encoder of colour and depth images; small, because it has to train on a CPU."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from ucon.core.jit import F32, U8, jit

FARTHEST_M = 10.0


def small_image(rgb: NDArray[np.uint8], depth: NDArray[np.float32], size: int) -> NDArray[np.uint8]:
    """Shrink a frame: means of colours, minima of depths.

    Args:
        rgb: (H, W, 3) uint8; H and W are multiples of ``size``.
        depth: (H, W) float32, metres.
        size: side of the result, in pixels.

    Returns:
        (4, size, size) uint8; depths from 0 to 10 m as 0 to 255.
    """
    out = np.empty((4, size, size), np.uint8)
    _shrink(np.ascontiguousarray(rgb), np.ascontiguousarray(depth), out)
    return out


@jit
def _shrink(rgb: U8, depth: F32, out: U8) -> None:
    size = out.shape[1]
    high, wide = depth.shape[0] // size, depth.shape[1] // size
    for i in range(size):
        for j in range(size):
            red, green, blue, near = 0, 0, 0, np.float32(FARTHEST_M)
            for v in range(i * high, (i + 1) * high):
                for u in range(j * wide, (j + 1) * wide):
                    red += rgb[v, u, 0]
                    green += rgb[v, u, 1]
                    blue += rgb[v, u, 2]
                    near = min(near, depth[v, u])
            count = high * wide
            out[0, i, j], out[1, i, j], out[2, i, j] = red // count, green // count, blue // count
            out[3, i, j] = np.uint8(max(near, np.float32(0.0)) * np.float32(255.0 / FARTHEST_M))


class Eye(nn.Module):
    """Four convolutions with group norm, and a linear layer."""

    def __init__(self, size: int, out: int) -> None:
        """Build the network.

        Args:
            size: side of the image in pixels, a multiple of 16.
            out: size of the vector.
        """
        super().__init__()
        widths = (4, 16, 32, 48, 48)
        layers: list[Any] = []
        for k, (a, b) in enumerate(pairwise(widths)):
            layers += [nn.Conv2d(a, b, 5 if k == 0 else 3, stride=2, padding=2 if k == 0 else 1), nn.GroupNorm(8, b)]
            layers += [nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Flatten(), nn.Linear(widths[-1] * (size // 16) ** 2, out), nn.ReLU())

    def forward(self, image: Tensor) -> Tensor:
        """Encode images (N, 4, size, size) uint8 as vectors (N, out)."""
        return self.layers(image.to(torch.get_default_dtype()) / 127.5 - 1.0)  # type: ignore[no-any-return]
