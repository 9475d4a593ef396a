"""ZSON's visual encoder: a ResNet-50 of half width with group norm, as in Habitat's baselines."""

from __future__ import annotations

from typing import Final

import torch
from torch import Tensor, nn

_DEPTHS: Final = (3, 4, 6, 3)
_EXPANSION: Final = 4


class Bottleneck(nn.Module):
    """Residual block: 1 x 1, 3 x 3 and 1 x 1 convolutions with group norm.

    Args:
        channels: of the input.
        width: of the 3 x 3 convolution; the output has four times as many channels.
        stride: of the 3 x 3 convolution.
        groups: of group norm.
    """

    def __init__(self, channels: int, width: int, stride: int, groups: int) -> None:
        super().__init__()
        out = width * _EXPANSION
        self.body = nn.Sequential(
            nn.Conv2d(channels, width, 1, bias=False), nn.GroupNorm(groups, width), nn.ReLU(),
            nn.Conv2d(width, width, 3, stride, 1, bias=False), nn.GroupNorm(groups, width), nn.ReLU(),
            nn.Conv2d(width, out, 1, bias=False), nn.GroupNorm(groups, out),
        )  # fmt: skip
        same = stride == 1 and channels == out
        projection = nn.Sequential(nn.Conv2d(channels, out, 1, stride, bias=False), nn.GroupNorm(groups, out))
        self.beside = nn.Identity() if same else projection

    def forward(self, x: Tensor) -> Tensor:
        """(N, channels, h, w) -> (N, 4 * width, h / stride, w / stride)."""
        return torch.relu(self.body(x) + self.beside(x))


class GroupNormResNet50(nn.Module):
    """Images (N, 3, H, W) to features (N, 32 * width, H / 32, W / 32).

    Args:
        width: channels of the first convolution; group norm has half as many groups.
    """

    def __init__(self, width: int = 32) -> None:
        super().__init__()
        groups = width // 2
        layers: list[nn.Module] = [
            nn.Conv2d(3, width, 7, 2, 3, bias=False), nn.GroupNorm(groups, width), nn.ReLU(), nn.MaxPool2d(3, 2, 1),
        ]  # fmt: skip
        channels = width
        for stage, depth in enumerate(_DEPTHS):
            for block in range(depth):
                stride = 2 if stage and not block else 1
                layers.append(Bottleneck(channels, width << stage, stride, groups))
                channels = (width << stage) * _EXPANSION
        self.layers, self.channels = nn.Sequential(*layers), channels

    def forward(self, images: Tensor) -> Tensor:
        """Features (N, 32 * width, H / 32, W / 32) of images (N, 3, H, W)."""
        found: Tensor = self.layers(images)
        return found


class RunningMeanAndVar(nn.Module):
    """Normalises each channel by the mean and variance of all images so far (Habitat's layer of that name).

    Habitat updates them in training-mode forward passes. Here the learner does (:meth:`update_statistics`), so that
    padding does not count and nothing changes while PPO compares probabilities.

    Args:
        channels: of the images.
    """

    mean: Tensor
    variance: Tensor
    count: Tensor

    def __init__(self, channels: int = 3) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(1, channels, 1, 1))
        self.register_buffer("variance", torch.zeros(1, channels, 1, 1))
        self.register_buffer("count", torch.zeros((), dtype=torch.int64))

    def forward(self, images: Tensor) -> Tensor:
        """Normalised images (N, C, H, W)."""
        deviation = self.variance.clamp(min=1e-2).sqrt()
        return (images - self.mean) / deviation

    @torch.no_grad()
    def update_statistics(self, images: Tensor) -> None:
        """Add images (N, C, H, W) to mean and variance, by the formula of Chan et al. for two sets combined."""
        n = images.shape[0]
        mean = images.mean((0, 2, 3), keepdim=True)
        variance = ((images - mean) ** 2).mean((0, 2, 3), keepdim=True)
        both = self.count + n
        spread = self.variance * self.count + variance * n + (mean - self.mean) ** 2 * self.count * n / both
        self.variance.copy_(spread / both)
        self.mean.copy_((self.mean * self.count + mean * n) / both)
        self.count.add_(n)
