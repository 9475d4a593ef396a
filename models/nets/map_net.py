"""A convolutional network that reads the map around the agent, and gives features of what lies around places in it."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from ucon.search.map_raster import CHANNELS, PIXEL_M, SIDE


class ResidualBlock(nn.Module):
    """Two 3 x 3 convolutions with a skip connection.

    Args:
        width: channels.
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.first, self.second = nn.Conv2d(width, width, 3, padding=1), nn.Conv2d(width, width, 3, padding=1)
        nn.init.zeros_(self.second.weight)
        assert self.second.bias is not None
        nn.init.zeros_(self.second.bias)

    def forward(self, x: Tensor) -> Tensor:
        """(B, C, H, W) to the same shape."""
        return x + self.second(functional.gelu(self.first(functional.gelu(x))))  # type: ignore[no-any-return]


class MapNet(nn.Module):
    """Features of places from the map: what is near them, at 1 m per pixel, and up to some 10 m away, at 2 m.

    Args:
        width: of the features.
        channels: of the convolutions at 1 m; those at 2 m have twice as many.
        blocks: residual blocks at 2 m.
    """

    def __init__(self, width: int, channels: int = 24, blocks: int = 2) -> None:
        super().__init__()
        self.stem = nn.Conv2d(len(CHANNELS), channels, 3, stride=2, padding=1)
        self.close = ResidualBlock(channels)
        self.down = nn.Conv2d(channels, 2 * channels, 3, stride=2, padding=1)
        self.wide = nn.Sequential(*[ResidualBlock(2 * channels) for _ in range(blocks)])
        self.out = nn.Linear(3 * channels, width)

    def forward(self, image: Tensor, xy: Tensor) -> Tensor:
        """Features of N places on B maps.

        Args:
            image: (B, C, 41, 41) from 0 to 255, of :func:`ucon.search.map_raster.map_raster`.
            xy: (B, N, 2) metres ahead and to the left of the agent.

        Returns:
            (B, N, width).
        """
        close = self.close(self.stem(image / 255.0))
        wide = self.wide(self.down(close))
        at = (xy / (PIXEL_M * (SIDE // 2))).flip(-1)[:, :, None]  # (B, N, 1, 2): the last axis of the image first
        found = [
            functional.grid_sample(features, at, padding_mode="border", align_corners=True)[..., 0]
            for features in (close, wide)
        ]
        return self.out(torch.cat(found, 1).transpose(1, 2))  # type: ignore[no-any-return]
